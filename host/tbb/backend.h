#pragma once

/// \file
/// The oneTBB backend. Runs inside the caller's tbb::task_arena or one of its own; its memory is
/// the host's. Work is cut into pieces by sizes alone, so that results do not depend on threads.

#include <atomic>
#include <memory>
#include <string>

#include "backend/backend.h"

namespace vasamesh {

/// Of the machine, at least 1.
int processor_count();

/// The processor's name as the kernel states it, else "CPU".
std::string processor_name();

/// How many threads are started where `asked` are wanted: at most four for each processor, since
/// more would only wait for each other.
int capped_threads(int asked);

/// \param threads  workers, capped; 0 for the machine's. Ignored with an arena.
/// \param task_arena  a tbb::task_arena of the caller's, or null.
/// \param total  shared with other backends, or null.
std::shared_ptr<Backend> make_tbb_backend(int threads, void* task_arena,
                                          std::shared_ptr<ByteAccount> total = nullptr);

}  // namespace vasamesh

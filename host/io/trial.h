#pragma once

/// \file
/// Trying out what may stop the program, or take memory without bound.

#include <cstdint>
#include <functional>

namespace vasamesh {

/// Runs `work` in a copy of this process, which prints nothing, whose changes are lost, and which
/// may take `most_bytes` of memory beyond what the process has, and a minute of processor time (a
/// second more for each 128 MiB of these). \return whether it returned: false after a signal (an
/// assertion of a library, a fault, the end of its time) or an exception that is no Error. True,
/// without a trial, where no copy can be made. \throws Error the one that `work` throws; cancelled,
/// where SIGINT, SIGTERM or SIGHUP ended the copy. \throws std::bad_alloc where `work` does and the
/// process itself may not take `most_bytes`.
bool survives(std::int64_t most_bytes, const std::function<void()>& work);

/// What a limit of the process (ulimit -v) leaves it to take.
std::int64_t memory_left();

/// What a library may take to read files of `bytes` in all, compressed ones among them.
inline std::int64_t reading_memory(std::int64_t bytes) {
  return (std::int64_t{1} << 28) + 200 * bytes;
}

}  // namespace vasamesh

#pragma once

/// \file
/// Ctrl-C, SIGTERM and a terminal that hangs up. The first one asks for the end: the conversion
/// stops between two passes and temporary files are removed. The second one ends the program at
/// once.

#include <atomic>

namespace vasamesh::cli {

/// Installs the handlers, before any work; signals that are ignored stay so. A file past the limit
/// of its size (ulimit -f) is a write that fails.
/// \param ask_first  false: nothing can be left half done, so the first signal ends the program.
void catch_interrupts(bool ask_first);

/// Set by the first signal.
const std::atomic<bool>& interrupted();

/// \throws Error cancelled, when a signal has come.
void stop_if_interrupted();

}  // namespace vasamesh::cli

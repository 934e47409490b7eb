#pragma once

/// \file
/// The program: reads the command line, runs one subcommand, turns errors into exit codes.

namespace vasamesh::cli {

/// \return the exit code, an ErrorCode or 0. Errors are one line on stderr.
int run(int argc, const char* const* argv);

}  // namespace vasamesh::cli

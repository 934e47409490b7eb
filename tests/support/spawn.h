#pragma once

/// \file
/// Running a program as a user does, for tests of the command line.

#include <string>
#include <vector>

namespace vasamesh {

/// What a program left behind.
struct Outcome {
  int code = 0;  ///< exit code; -1 - signal when one ended it
  std::string out, err;
};

/// Runs `arguments[0]` to its end. \param stdout_to  a file for stdout, where `out` stays empty.
Outcome run_program(const std::vector<std::string>& arguments, const std::string& stdout_to = {});

/// Runs a program whose stderr is a terminal, sends it `signal` as soon as that terminal has shown
/// `cue`, and waits for its end. `err` holds what the terminal showed.
Outcome interrupt_program(const std::vector<std::string>& arguments, const std::string& cue,
                          int signal);

/// As above without a signal.
Outcome run_on_terminal(const std::vector<std::string>& arguments);

}  // namespace vasamesh

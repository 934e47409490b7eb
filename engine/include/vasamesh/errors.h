#pragma once

/// \file
/// The one error type of vasamesh. It is thrown inside and turned once at each edge: into an exit
/// code by the program, later into status codes and Python exceptions by the bindings.

#include <stdexcept>
#include <string>

namespace vasamesh {

/// What went wrong. The value is the program's exit code.
enum class ErrorCode : int {
  internal = 1,       ///< our own fault: an invariant of the code does not hold
  usage = 2,          ///< wrong use: an option or parameter out of its range
  bad_input = 3,      ///< the input cannot be used: the message names file, reason and remedy
  failed_check = 4,   ///< a surface failed its proof
  no_device = 5,      ///< the backend or device that was asked for is not there
  refused = 6,        ///< output or memory refused: folder, disk or memory limit
  cancelled = 130,    ///< the caller, or Ctrl-C, stopped the work
};

/// An error with a code and one line of text: what is wrong (with the name of the file or option),
/// why, and what to do about it.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace vasamesh

#pragma once

/// \file
/// Errors about files, in one line each: which file, what is wrong with it, what to do.

#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

[[noreturn]] inline void throw_bad_input(const std::string& path, const std::string& reason,
                                         const std::string& remedy) {
  throw Error(ErrorCode::bad_input, path + ": " + reason + "; " + remedy);
}

[[noreturn]] inline void throw_refused(const std::string& path, const std::string& reason,
                                       const std::string& remedy) {
  throw Error(ErrorCode::refused, path + ": " + reason + "; " + remedy);
}

}  // namespace vasamesh

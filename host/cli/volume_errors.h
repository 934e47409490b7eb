#pragma once

/// \file
/// What the library, which knows no files, has against a volume.

#include <string>

#include "vasamesh/errors.h"

namespace vasamesh::cli {

/// Runs `work` on the volume of a file. \throws Error of `work`, bad_input with the file's name.
template <class Work>
auto on_volume_of(const std::string& path, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::bad_input) throw;
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace vasamesh::cli

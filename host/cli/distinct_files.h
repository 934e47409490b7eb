#pragma once

/// \file
/// Outputs that would replace an input, or each other.

#include <string>
#include <vector>

namespace vasamesh::cli {

/// A file or folder of the command line.
struct NamedFile {
  std::string name;  ///< of the option or argument
  std::string path;  ///< empty: not given
};

/// Links and other spellings of a path are seen through.
/// \throws Error usage, when an output is an input, or a file of an input's folder that may be a
///         slice, or two outputs are one.
void check_distinct(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs);

}  // namespace vasamesh::cli

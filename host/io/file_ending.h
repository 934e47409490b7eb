#pragma once

/// \file
/// Endings of file names, which choose the format.

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string>
#include <string_view>

namespace vasamesh {

/// The entry of `endings` that `path` ends in, upper and lower case alike; empty when none. Longer
/// endings come first in the list (".nii.gz" before ".gz").
inline std::string file_ending(std::string path, std::initializer_list<std::string_view> endings) {
  std::transform(path.begin(), path.end(), path.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (std::string_view ending : endings) {
    if (path.ends_with(ending)) return std::string(ending);
  }
  return {};
}

}  // namespace vasamesh

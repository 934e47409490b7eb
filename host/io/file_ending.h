#pragma once

/// \file
/// Endings of file names, which choose the format.

#include <initializer_list>
#include <string>
#include <string_view>

#include "lower_case.h"

namespace vasamesh {

/// The entry of `endings` that `path` ends in, upper and lower case alike; empty when none. Longer
/// endings come first in the list (".nii.gz" before ".gz").
inline std::string file_ending(const std::string& path,
                               std::initializer_list<std::string_view> endings) {
  const std::string lower = lower_case(path);
  for (std::string_view ending : endings) {
    if (lower.ends_with(ending)) return std::string(ending);
  }
  return {};
}

}  // namespace vasamesh

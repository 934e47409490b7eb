#pragma once

/// \file
/// Text compared without regard to case.

#include <algorithm>
#include <cctype>
#include <string>

namespace vasamesh {

inline std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace vasamesh

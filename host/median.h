#pragma once

/// \file
/// The median of measurements.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vasamesh {

/// The upper one of two in the middle. \pre there is a value.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace vasamesh

#pragma once

/// \file
/// Where volumes lie, for tests of what is read from their files.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "vasamesh/types.h"

namespace vasamesh {

/// Rotated about two axes; column `mirrored` is turned round.
inline std::array<double, 9> oblique(bool mirrored) {
  const double a = 0.3, b = -0.7;
  const double sign = mirrored ? -1 : 1;
  return {std::cos(a),
          -std::sin(a) * std::cos(b),
          sign * std::sin(a) * std::sin(b),
          std::sin(a),
          std::cos(a) * std::cos(b),
          sign * -std::cos(a) * std::sin(b),
          0,
          std::sin(b),
          sign * std::cos(b)};
}

inline void expect_near(const Geometry& got, const Geometry& wanted) {
  EXPECT_EQ(got.size, wanted.size);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(got.spacing[i], wanted.spacing[i], 1e-6);
    EXPECT_NEAR(got.origin[i], wanted.origin[i], 1e-4);
  }
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(got.direction[i], wanted.direction[i], 1e-6) << i;
}

}  // namespace vasamesh

#pragma once

/// \file
/// Weights of the Gaussian occupancy gradient, made once on the host for every backend.
///
/// Points lie at multiples of 1/24 voxel along each axis (faces, halves, quarters and thirds of
/// them), so the weights of one axis are a table over those 24 fractions and the voxels in reach.
/// Along x, the sums over a row of bits are tabulated as well, by patterns of 8 bits.

#include <array>
#include <vector>

#include "types/point_cloud.h"

namespace vasamesh {

inline constexpr int kFractions = 24;        ///< places of a point in a voxel, along an axis
inline constexpr int kMaxGradientReach = 7;  ///< voxels; within the padding
inline constexpr int kMaxGradientSpan = 2 * kMaxGradientReach + 1;

/// Sum of the weights, and of weight times offset.
struct GradientSum {
  float weight, moment;
};

/// Offsets are physical: (centre of voxel - point) * scale, in voxel lengths.
struct GradientTable {
  /// Voxels base - reach .. base + reach of an axis take part; base = floor(point).
  std::array<int, 3> reach;
  /// [axis y: 0, z: 1][fraction][voxel - base + reach], kMaxGradientSpan entries a fraction.
  std::array<std::vector<GradientSum>, 2> voxel;
  /// [fraction][half][pattern], 256 patterns a half: bits 0..7 and 8..15 of the row's bits from
  /// base - reach.
  std::vector<GradientSum> row;

  const GradientSum* voxels(int axis, int fraction) const {
    return &voxel[axis - 1][static_cast<std::size_t>(fraction) * kMaxGradientSpan];
  }
  const GradientSum* rows(int fraction) const {
    return &row[static_cast<std::size_t>(fraction) * 512];
  }
};

/// Along each axis exp(-d^2 / 2 sigma^2) less its value at three sigma, where it ends: without the
/// step a point between voxel centres feels no tilt.
/// \param sigma  standard deviation in voxel lengths.
GradientTable make_gradient_table(const Scale& scale, float sigma);

/// A coordinate as floor and twenty-fourths. \pre position is at least 0.
struct LatticePlace {
  int base, fraction;
};
inline LatticePlace lattice_place(float position) {
  const int base = static_cast<int>(position);
  const int fraction = static_cast<int>(
      (position - static_cast<float>(base)) * static_cast<float>(kFractions) + 0.5f);
  return fraction == kFractions ? LatticePlace{base + 1, 0} : LatticePlace{base, fraction};
}

}  // namespace vasamesh

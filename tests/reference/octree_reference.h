#pragma once

/// \file
/// Slow plain oracles of the indicator function, in double precision: quadratic B-splines
/// evaluated at a point, and the splatted field's divergence as a sum over all samples.

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "types/octree.h"
#include "types/point_cloud.h"

namespace vasamesh::reference {

using Position = std::array<double, 3>;  ///< padded voxel units

/// Quadratic B-spline of unit knots, centred.
double bspline(double t);

/// A sum of quadratic B-splines on the cells of a level; cells that are not there count as zero.
class SplineField {
 public:
  SplineField(int exponent, std::span<const BrickCoord> bricks, std::span<const float> values);

  double at(const Position& position) const;

  /// Whether all the 27 cells whose splines reach the position are there.
  bool covers(const Position& position) const;

 private:
  template <class Visit>
  void visit(const Position& position, const Visit& visit) const;
  double side_;  ///< of a cell, voxels
  std::unordered_map<std::int64_t, float> cells_;
};

/// Eq. 3 and 4 of the paper: -volume * div V at the cell (in cells) of a level, V = sum over the
/// points of -(area . normal) normal K, div by the differences over the cell's faces.
double splatted(const PointView& points, const Scale& scale, const Kernel& kernel, int exponent,
                const std::array<int, 3>& cell);

}  // namespace vasamesh::reference

#pragma once

/// \file
/// The surface of a function by continuation: from cubes of a grid that the surface crosses to
/// their neighbours, each cut into polygons along its faces.
///
/// Bloomenthal: An implicit surface polygonizer, Graphics Gems IV, 1994, with its cubes (not
/// tetrahedra) and vertices found by bisection.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "vasamesh/types.h"

namespace vasamesh::baselines {

struct Polygonization {
  double cube = 1;  ///< edge of the grid's cubes, above zero
  /// The search starts round these places; what no place is near to is not found.
  std::vector<Eigen::Vector3d> seeds;
};

/// The zero set of `value` (negative inside), closed, facing outward.
/// \throws Error refused when it crosses more than 2^26 cubes.
TriangleMesh polygonize(const std::function<double(const Eigen::Vector3d&)>& value,
                        const Polygonization& options);

}  // namespace vasamesh::baselines

#pragma once

/// \file
/// Point extraction as the paper tells it, voxel by voxel, in double.

#include <array>
#include <vector>

#include "support/dense_volume.h"
#include "types/point_cloud.h"

namespace vasamesh::reference {

using test::DenseVolume;

struct Point {
  std::array<int, 3> voxel;  ///< the outer boundary voxel
  std::array<double, 3> position, area;
  double thickness;
  bool refined;
};

/// The volume with kPad background voxels before it, at least as many after it, and sizes that are
/// multiples of eight.
DenseVolume padded(const DenseVolume& volume);

/// 3 x 3 x 3 morphology; outside counts as background.
DenseVolume eroded(const DenseVolume& volume);
DenseVolume dilated(const DenseVolume& volume);

/// The volume minus its opening.
DenseVolume top_hat(const DenseVolume& volume);

/// Background with an object 6-neighbour.
bool is_outer_boundary(const DenseVolume& volume, const std::array<int, 3>& voxel);

/// The samples of a padded volume, in the order that engine/stages/points.h states.
std::vector<Point> extract_points(const DenseVolume& object, const Scale& scale);

}  // namespace vasamesh::reference

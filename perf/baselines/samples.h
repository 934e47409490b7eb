#pragma once

/// \file
/// The library's oriented samples of a segmentation, for methods that start from points.

#include <Eigen/Core>
#include <vector>

#include "io/volume_reader.h"
#include "types/point_cloud.h"
#include "vasamesh/types.h"

namespace vasamesh::baselines {

/// Lengths in voxels (geometric mean of the spacings), along the volume's own axes.
struct Sample {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;  ///< outward, unit length
};

/// Section "Point extraction" and "Normal vector estimation" of the paper, with the default
/// parameters.
std::vector<Sample> oriented_samples(const Segmentation& segmentation);

/// Moves vertices from the samples' frame to mm, LPS, and keeps the triangles outward.
void place_in_lps(const Geometry& geometry, TriangleMesh& mesh);

}  // namespace vasamesh::baselines

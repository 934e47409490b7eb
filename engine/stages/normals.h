#pragma once

/// \file
/// Normal vectors of the samples (Section "Normal vector estimation" of the paper).
///
/// Covariance (eq. 1 of the paper, which lacks the 1/k of the mean): the eigenvector of the
/// smallest eigenvalue over the k nearest neighbours. On vessels of one or two voxels both sheets
/// lie within reach, so only neighbours are taken whose occupancy gradient agrees with the point's
/// own; that gradient gives the sign as well, and the normal where the covariance tells no plane.

#include "backend/backend.h"
#include "types/point_cloud.h"
#include "types/volume.h"
#include "vasamesh/parameters.h"

namespace vasamesh {

/// Standard deviation of the occupancy's Gaussian, in voxel lengths: where it steers the
/// covariance, and where it is the normal itself.
inline constexpr float kSteeringSigma = 1.0f;
inline constexpr float kGradientSigma = 1.5f;

/// Least cosine between the gradients of two points of one sheet.
inline constexpr float kSameSheet = 0.5f;

/// The smallest eigenvalue must be below this part of the middle one; otherwise no plane is told.
inline constexpr float kPlaneRatio = 0.7f;

/// Neighbours are looked for in the (2 r + 1)^3 voxels round a point's own, r growing to this.
inline constexpr int kNeighbourReach = 3;

/// Fills points.normal by parameters.normals.
void estimate_normals(Backend& backend, const BitVolume& object, const Scale& scale,
                      const Parameters& parameters, PointCloud& points);

}  // namespace vasamesh

#pragma once

/// \file
/// Normal vectors of the samples (Section "Normal vector estimation" of the paper).
///
/// Gradient: the direction in which the Gaussian-smoothed occupancy falls fastest.
///
/// Covariance (eq. 1 of the paper, which lacks the 1/k of the mean): the eigenvector of the
/// smallest eigenvalue over the k nearest neighbours. On vessels of one or two voxels both sheets
/// lie within reach, so only samples count whose occupancy gradient agrees with the point's own;
/// that gradient gives the sign as well, and the normal where the covariance tells no plane.
/// Neighbours are outer boundary voxels, each at the mean of its samples: the four to seven samples
/// of a refined voxel lie on the same faces, and k of them would see but one step of the lattice.

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

/// Least cosine between that plane's normal and the gradient: a plane further off is one step of a
/// staircase, or spans two sheets.
inline constexpr float kPlaneAgrees = 0.9f;

/// Neighbours are looked for in the (2 r + 1)^3 voxels round a point's own, with r = 2, and with
/// this r where the farthest of them might miss a nearer one.
inline constexpr int kNeighbourReach = 3;

/// Below this square a gradient is taken to vanish.
inline constexpr float kNoGradient = 1e-12f;

/// Square of the sine by which a gradient may point against the faces behind its point; beyond it
/// another vessel has drowned the point's own.
inline constexpr float kAgainstFaces = 0.0625f;

/// Fills points.normal by parameters.normals.
void estimate_normals(Backend& backend, const BitVolume& object, const Scale& scale,
                      const Parameters& parameters, PointCloud& points);

}  // namespace vasamesh

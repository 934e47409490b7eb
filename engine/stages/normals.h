#pragma once

/// \file
/// Normal vectors of the samples (Section "Normal vector estimation" of the paper).
///
/// Gradient mode: the direction in which the Gaussian-smoothed occupancy falls fastest.
///
/// Covariance mode: the eigenvector of the smallest eigenvalue of
///   C = 1/k sum (p_i - mean) (p_i - mean)^T + tau (1 - g g^T)
/// over the k nearest neighbours p_i (eq. 1 of the paper, which lacks the 1/k of the mean),
/// oriented by the occupancy gradient g. Three things make it hold where the paper's does not:
///  - On vessels of one or two voxels both sheets lie within reach. Only samples count whose
///    gradient agrees with the point's own.
///  - The four to seven samples of a refined voxel lie on the same faces, and k of them would see
///    but one step of the lattice. A neighbour is an outer boundary voxel, at the mean of its
///    samples.
///  - Where few neighbours are left, or all lie on one step, they tell no plane. The second term,
///    the tangent plane of the gradient, decides there, and fades as k grows.

#include "backend/backend.h"
#include "types/point_cloud.h"
#include "types/volume.h"
#include "vasamesh/parameters.h"

namespace vasamesh {

/// Standard deviation of the occupancy's Gaussian, in voxel lengths: where it steers the
/// covariance, and where it is the normal itself.
inline constexpr float kSteeringSigma = 1.25f;
inline constexpr float kGradientSigma = 1.5f;

/// Least cosine between the gradients of two points of one sheet.
inline constexpr float kSameSheetGradients = 0.5f;

/// tau, in squared voxel lengths: about what ten neighbours spread along the surface.
inline constexpr float kTangentWeight = 0.8f;

/// Neighbours are looked for in the (2 r + 1)^3 voxels round a point's own.
inline constexpr int kNeighbourReach = 3;

/// Below this square a gradient is taken to vanish.
inline constexpr float kNoGradient = 1e-6f;

/// Square of the sine by which a normal may point against the faces behind its point; beyond it
/// another vessel has drowned the point's own.
inline constexpr float kAgainstFaces = 0.0625f;

/// Fills points.normal by parameters.normals.
void estimate_normals(Backend& backend, const BitVolume& object, const Scale& scale,
                      const Parameters& parameters, PointCloud& points);

}  // namespace vasamesh

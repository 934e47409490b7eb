#pragma once

/// \file
/// Distances between two surfaces, both ways: samples spread evenly over the one, the exact nearest
/// point on the other.
///
/// Aspert, Santa-Cruz, Ebrahimi: MESH: measuring errors between surfaces using the Hausdorff
/// distance, 2002.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/triangle_tree.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Distances from one surface to another, in mm.
struct OneWayDistance {
  double mean = 0;  ///< over the area
  double rms = 0;
  double maximum = 0;  ///< over samples and vertices
};

struct DistanceReport {
  OneWayDistance to;    ///< from the surface to the reference
  OneWayDistance back;  ///< from the reference to the surface
  double voxel = 1;     ///< mm: divide by it for voxels
};

/// \param voxel  length of a voxel in mm (geometric mean of the spacings), above zero.
/// \param step  largest distance of neighbouring samples, in voxels, above zero: a triangle is cut
///        into n^2 equal ones, n the longest edge over the step, with a sample at each centroid.
/// \throws Error bad_input, when either surface has no triangle or a vertex that is not finite, or
///         the samples would lie no distance apart (a voxel taken from a reference without area).
DistanceReport measure_distance(Backend& backend, const TriangleMesh& surface,
                                const TriangleMesh& reference, double voxel, double step = 0.25);

/// The distance of each point to a surface, in its unit. Quick for points near the one before.
/// \pre the surface's vertices are finite, and the tree is that of its triangles, at least one.
std::vector<float> distances_to(Backend& backend, std::span<const Vec3> points,
                                const TriangleMesh& surface, const TriangleTree& tree);

/// The same, and the nearest triangle of each point; for a point that is not farther than `enough`
/// some triangle and its distance, not more than that.
struct NearestTriangles {
  std::vector<float> distances;
  std::vector<std::uint32_t> triangles;
};
NearestTriangles nearest_triangles(Backend& backend, std::span<const Vec3> points,
                                   const TriangleMesh& surface, const TriangleTree& tree,
                                   float enough);

}  // namespace vasamesh

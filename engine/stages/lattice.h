#pragma once

/// \file
/// The segmentation and the indicator function on the cell lattice.
///
/// A node is inside the solid when any voxel that it touches is object; under the Freudenthal cut
/// that labelling has the solid's topology. (With connectivity 18 and 6 fewer nodes are inside:
/// see topology_count.h.) Bricks are kept near the boundary alone.

#include <array>
#include <cstdint>

#include "backend/backend.h"
#include "types/lattice.h"
#include "types/octree.h"
#include "types/point_cloud.h"
#include "types/volume.h"
#include "vasamesh/parameters.h"

namespace vasamesh {

/// How far a surface may be from the segmentation's marching cubes, in voxel lengths: the larger
/// of the smallest spacing and 0.55 of the largest. With a kernel wider than the default's, which
/// is to smooth away more, as much more in proportion.
/// \param kernel_width  as of Parameters.
float distance_limit(const Scale& scale, double kernel_width);

/// Part of the distance limit that the labels may use; the rest is for the surface between.
inline constexpr float kDistanceShare = 0.8f;

/// The bricks of nodes near the boundary, with the solid's labels and the field's values.
Lattice build_lattice(Backend& backend, const BitVolume& object, const PointCloud& points,
                      const Scale& scale, const Octree& octree, const Parameters& parameters);

}  // namespace vasamesh

#pragma once

/// \file
/// How many bytes a conversion will hold, known once its boundary is.

#include <cstddef>

#include "types/point_cloud.h"
#include "types/volume.h"

namespace vasamesh {

/// Bounds of the most that the backends' buffers hold at a time.
struct BytePlan {
  std::size_t least = 0, most = 0;
};

/// The bit-packed volume and the samples stay until the field is solved for. Every sample brings
/// its share of octree, lattice and surface: 450 to 1140 bytes on fifteen phantoms of more than a
/// thousand samples, by how far apart these lie, and 200 where each voxel has many. Of specks that
/// lie alone the octree is what counts, up to 20,000 bytes a sample: 5500 to 9000 a brick, of all
/// its levels.
/// \param octree_bricks  of all levels.
BytePlan plan_bytes(const BitView& object, const PointCloud& points, std::size_t octree_bricks);

}  // namespace vasamesh

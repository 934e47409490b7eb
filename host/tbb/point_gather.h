#pragma once

/// \file
/// Reaching the points near a brick, for the passes that gather.

#include <algorithm>
#include <cstdint>

#include "types/octree.h"
#include "types/point_cloud.h"

namespace vasamesh {

/// The voxels of a brick of a level, first to last + 1, along one axis.
struct VoxelRange {
  int first, last;
};

inline VoxelRange brick_voxels(int exponent, int brick) {
  if (exponent < 0) return {brick * 8 >> -exponent, (brick + 1) * 8 >> -exponent};
  return {brick * (8 << exponent), (brick + 1) * (8 << exponent)};
}

/// Calls visit(first point, last point + 1) for the points of all voxels in the box, row by row
/// in a fixed order: z, y, then point bricks along x. The box must lie within the bricks that
/// `index` holds for `brick`.
template <class Visit>
void visit_points(const PointIndex& index, int exponent, std::size_t brick, const BrickCoord& coord,
                  const VoxelRange (&box)[3], const Visit& visit) {
  const int base[3] = {(brick_voxels(exponent, coord.x).first >> 3) - 1,
                       (brick_voxels(exponent, coord.y).first >> 3) - 1,
                       (brick_voxels(exponent, coord.z).first >> 3) - 1};
  const std::size_t side = static_cast<std::size_t>(index.side);
  const std::int32_t* table = index.bricks.data() + side * side * side * brick;
  for (int z = box[2].first; z < box[2].last; ++z)
    for (int y = box[1].first; y < box[1].last; ++y) {
      const std::int32_t* row = table + side * (((y >> 3) - base[1]) + side * ((z >> 3) - base[2]));
      for (int bx = box[0].first >> 3; bx <= (box[0].last - 1) >> 3; ++bx) {
        const std::int32_t found = row[bx - base[0]];
        if (found == kNoBrick) continue;
        const int x0 = std::max(box[0].first - 8 * bx, 0);
        const int x1 = std::min(box[0].last - 8 * bx, 8);
        const std::uint32_t* start = index.voxel_start.data() +
                                     512 * static_cast<std::size_t>(found) +
                                     brick_cell(0, y & 7, z & 7);
        if (start[x0] != start[x1]) visit(start[x0], start[x1]);
      }
    }
}

}  // namespace vasamesh

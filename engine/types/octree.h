#pragma once

/// \file
/// The octree as a cascade of brick levels, each a narrow band round the samples, and the
/// coefficients of the indicator function on them.

#include <array>
#include <cstdint>
#include <vector>

#include "types/bricks.h"
#include "types/buffer.h"
#include "types/point_cloud.h"

namespace vasamesh {

/// What a pass needs to know of one level. Cell (x, y, z) of the level is the box of 2^exponent
/// padded voxels a side at 2^exponent * (x, y, z); exponent is 0 for the regular finest level, -1
/// for the refinement of thin vessels, and grows towards the root.
struct LevelView {
  int exponent = 0;
  BrickView bricks;
  std::array<float, 3> weights{1, 1, 1};  ///< vol / h_i^2 of the 7-point operator, in voxel lengths
};

struct OctreeLevel {
  int exponent = 0;  ///< cell side = 2^exponent voxels
  std::array<float, 3> weights{1, 1, 1};
  std::vector<BrickCoord> coords;  ///< the bricks' coordinates, for the host
  Bricks bricks;
  Buffer<std::int32_t> parents;   ///< a brick: 27 bricks of the next coarser level round its
                                  ///< parent; empty at the root
  Buffer<std::uint8_t> unknown;   ///< a cell: 1 is solved for, 0 keeps the coarser level's value
  Buffer<float> right_hand_side;  ///< a cell: -volume * divergence of the splatted field; like
                                  ///< `unknown` empty once the level is solved
  Buffer<float> solution;         ///< a cell: coefficient of the quadratic B-spline

  LevelView view() const { return {exponent, bricks.view(), weights}; }
};

/// Levels from the root (at most 3 x 3 x 3 bricks, from -1 to 1) to the finest: the regular one
/// (exponent 0) and, where vessels are thin, the refined one (exponent -1).
struct Octree {
  std::vector<OctreeLevel> levels;

  int root_exponent() const { return levels.front().exponent; }
  OctreeLevel& at_exponent(int exponent) {
    return levels[static_cast<std::size_t>(root_exponent() - exponent)];
  }
  const OctreeLevel& at_exponent(int exponent) const {
    return levels[static_cast<std::size_t>(root_exponent() - exponent)];
  }
  bool has_refined() const { return levels.back().exponent < 0; }

  /// Depth of a level: 4 at the root, whose bricks about the volume are two wide, 2^4 cells.
  int depth(const OctreeLevel& level) const { return 4 + root_exponent() - level.exponent; }
};

}  // namespace vasamesh

#pragma once

/// \file
/// The octree as a cascade of brick levels, each a narrow band round the samples, and the
/// coefficients of the indicator function on them.

#include <array>
#include <cstdint>
#include <vector>

#include "backend/buffer.h"
#include "types/bricks.h"

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
  int depth = 0;     ///< 0 is the root
  int exponent = 0;  ///< cell side = 2^exponent voxels
  std::array<float, 3> weights{1, 1, 1};
  Bricks bricks;
  Buffer<std::uint8_t> unknown;   ///< a cell: 1 is solved for, 0 keeps the coarser level's value
  Buffer<float> right_hand_side;  ///< a cell: -volume * divergence of the splatted field
  Buffer<float> solution;         ///< a cell: coefficient of the quadratic B-spline

  LevelView view() const { return {exponent, bricks.view(), weights}; }
};

/// Levels from the root to the finest.
struct Octree {
  std::vector<OctreeLevel> levels;
};

}  // namespace vasamesh

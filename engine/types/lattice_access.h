#pragma once

/// \file
/// Reaching nodes across bricks of the cell lattice.

#include <cstdint>

#include "types/bricks.h"
#include "types/lattice.h"

namespace vasamesh {

inline constexpr std::size_t kNoNode = ~std::size_t{0};

/// Index (512 * brick + cell) of the node at (x, y, z), each -8..15 from the corner of `brick`;
/// kNoNode where its brick is not there.
inline std::size_t node_at(const std::int32_t* near, int x, int y, int z) {
  const std::int32_t brick = near[((x + 8) >> 3) + 3 * (((y + 8) >> 3) + 3 * ((z + 8) >> 3))];
  if (brick == kNoBrick) return kNoNode;
  return std::size_t{kBrickCells} * static_cast<std::size_t>(brick) +
         static_cast<std::size_t>(brick_cell(x & 7, y & 7, z & 7));
}

}  // namespace vasamesh

#pragma once

/// \file
/// Bricks: 8 x 8 x 8 cells of one level, the leaves of the octree without pointers. All data of a
/// level are flat arrays of 512 values a brick; a table holds the 27 neighbours of each.

#include <array>
#include <cstdint>

#include "types/buffer.h"

namespace vasamesh {

inline constexpr int kBrickSide = 8;
inline constexpr int kBrickCells = 512;
inline constexpr int kNoBrick = -1;

/// The cell (x, y, z), each 0..7, of a brick: x varies fastest.
constexpr int brick_cell(int x, int y, int z) { return x + 8 * (y + 8 * z); }

/// The entry of a brick's neighbour table for an offset (dx, dy, dz), each -1..1; 13 is itself.
constexpr int brick_neighbour(int dx, int dy, int dz) {
  return (dx + 1) + 3 * ((dy + 1) + 3 * (dz + 1));
}

/// A brick's coordinates, in bricks; may be negative on coarse levels.
struct BrickCoord {
  std::int32_t x, y, z;
  bool operator==(const BrickCoord&) const = default;
};

/// Bricks of one level in raster order (z, then y, then x): `coords` has one entry a brick,
/// `neighbours` 27 (an index or kNoBrick).
struct BrickView {
  std::size_t count = 0;
  View<const BrickCoord> coords;
  View<const std::int32_t> neighbours;
};

struct Bricks {
  std::size_t count = 0;
  Buffer<BrickCoord> coords;
  Buffer<std::int32_t> neighbours;

  BrickView view() const { return {count, coords.view(), neighbours.view()}; }
};

}  // namespace vasamesh

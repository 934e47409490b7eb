#pragma once

/// \file
/// What the test for labels that are too far from the segmentation keeps of a brick (far.cpp).

#include <algorithm>
#include <cstdint>

#include "types/lattice_access.h"

namespace vasamesh {

/// The states of a brick's nodes and of those up to four away; kMissing where there is none.
struct StateHalo {
  static constexpr int kMargin = 4;
  static constexpr int kSide = 8 + 2 * kMargin;

  static constexpr int at(int x, int y, int z) {
    return (x + kMargin) + kSide * ((y + kMargin) + kSide * (z + kMargin));
  }

  StateHalo(const std::int32_t* near, const std::uint8_t* state) {
    for (int z = -kMargin; z < 8 + kMargin; ++z)
      for (int y = -kMargin; y < 8 + kMargin; ++y) {
        std::uint8_t* row = values + at(0, y, z);
        take(node_at(near, -kMargin, y, z), kMargin, state, row - kMargin);
        take(node_at(near, 0, y, z), 8, state, row);
        take(node_at(near, 8, y, z), kMargin, state, row + 8);
      }
  }

  /// The states of nodes in a row of a brick.
  static void take(std::size_t first, int count, const std::uint8_t* state, std::uint8_t* to) {
    if (first == kNoNode)
      std::fill_n(to, count, kMissing);
    else
      std::copy_n(state + first, count, to);
  }

  static constexpr std::uint8_t kMissing = 0x80;
  std::uint8_t values[kSide * kSide * kSide];
};

/// The nodes of a row of a brick that lie in some of its octants (bit dx + 2 dy + 4 dz), bit x.
inline std::uint32_t octant_row(std::uint32_t octants, int y, int z) {
  const std::uint32_t along = octants >> (2 * (y >> 2) + 4 * (z >> 2));
  return (along & 1) * 0x0fu | (along >> 1 & 1) * 0xf0u;
}

/// Those of row (y, z), each -1..7, that lie there or one node beside, bit x + 1.
inline std::uint32_t beside_octants(std::uint32_t octants, int y, int z) {
  std::uint32_t row = 0;
  for (const int k : {std::max(z - 1, 0), std::min(z + 1, 7)})
    for (const int j : {std::max(y - 1, 0), std::min(y + 1, 7)}) row |= octant_row(octants, j, k);
  return row | row << 1 | row << 2;
}

struct FarNode {
  int x, y, z;
};

/// What is found round the face centres of a brick's marching cubes.
struct FacesNear {
  static constexpr int kSide = 9;
  static constexpr int at(int x, int y, int z) {
    return (x + 1) + kSide * ((y + 1) + kSide * (z + 1));
  }
  /// The crossed faces of the cube round a corner, as bits of kCubeFaces.
  std::uint32_t crossed(const FarNode& corner) const {
    const auto row = [&](int y, int z) {
      return rows[corner.z + z + 1][corner.y + y + 1] >> corner.x;
    };
    const auto one = [](std::uint32_t bits) { return bits >> 1 & 1; };
    const auto two = [](std::uint32_t bits) { return (bits & 1) | (bits >> 1 & 2); };
    return one(row(-1, -1)) | one(row(1, -1)) << 1 | one(row(-1, 1)) << 2 | one(row(1, 1)) << 3 |
           two(row(0, -1)) << 4 | two(row(0, 1)) << 6 | two(row(-1, 0)) << 8 | two(row(1, 0)) << 10;
  }

  std::uint32_t rows[kSide][kSide];  ///< z, y from -1; bit x + 1: a face centre
  float
      distance[kSide * kSide * kSide];  ///< to the surface, from above, of faces that are asked for
};

}  // namespace vasamesh

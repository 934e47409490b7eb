#pragma once

/// \file
/// Sampling of a solid on a regular lattice, near its surface only: the lattice is halved until a
/// block is small or clear of the surface.

#include <array>
#include <cstdint>
#include <vector>

#include "phantom/solid.h"
#include "vasamesh/types.h"

namespace vasamesh::phantom {

using Index3 = std::array<int, 3>;

/// Nodes at start + step * (i, j, k), 0 <= i < size[0] and so on.
struct VoxelGrid {
  Index3 size{0, 0, 0};
  Vec3 start = Vec3::Zero();
  Vec3 step = Vec3::Ones();

  Vec3 node(int i, int j, int k) const {
    return start + Vec3(i * step[0], j * step[1], k * step[2]);
  }
};

/// Nodes low <= (i, j, k) < high of a lattice.
struct Block {
  Index3 low, high;
  bool inside;  ///< all of them lie deeper inside than the margin
  Shape solid;  ///< what is near; empty where `inside`
};

/// Blocks of at most `side` nodes a side that together hold every node no farther outside than
/// `margin`; within that margin the block's own solid gives the distance. In a fixed order.
std::vector<Block> find_blocks(const Shape& solid, const VoxelGrid& lattice, int side,
                               double margin);

/// Sets the voxels whose centres lie inside. `voxels` has lattice.size, i fastest.
void voxelise(const Shape& solid, const VoxelGrid& lattice, std::vector<std::uint8_t>& voxels);

/// Sets the voxels that a polyline runs through: the nearest ones to its points, 26-connected.
/// Parts outside the lattice are left out.
void draw_line(const std::vector<Vec3>& points, const VoxelGrid& lattice,
               std::vector<std::uint8_t>& voxels);

}  // namespace vasamesh::phantom

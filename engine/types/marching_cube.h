#pragma once

/// \file
/// The polygons of marching cubes (of the segmentation's 0 and 1, at a half) on the cell lattice. A
/// cube has its corners at eight voxel centres and lies round a lattice corner, a node of even
/// coordinates; its polygons' vertices are the centres of faces between object and background.
///
/// Lorensen, Cline: Marching cubes, 1987; ambiguous sides part the object's voxels.

#include <array>
#include <cstddef>
#include <cstdint>

#include "types/lattice.h"

namespace vasamesh {

/// The twelve edges of a marching cube round a lattice corner: the faces between its voxels.
inline constexpr std::array<NodeOffset, 12> kCubeFaces = {{{0, -1, -1},
                                                           {0, 1, -1},
                                                           {0, -1, 1},
                                                           {0, 1, 1},
                                                           {-1, 0, -1},
                                                           {1, 0, -1},
                                                           {-1, 0, 1},
                                                           {1, 0, 1},
                                                           {-1, -1, 0},
                                                           {1, -1, 0},
                                                           {-1, 1, 0},
                                                           {1, 1, 0}}};

/// The edges of the cube (of kCubeFaces) on each of its six sides.
inline constexpr std::array<std::array<int, 4>, 6> kCubeSides = [] {
  std::array<std::array<int, 4>, 6> sides{};
  for (std::size_t side = 0; side < 6; ++side) {
    std::size_t found = 0;
    for (std::size_t i = 0; i < 12; ++i) {
      const NodeOffset o = kCubeFaces[i];
      const int along = side / 2 == 0 ? o.x : side / 2 == 1 ? o.y : o.z;
      if (along == (side % 2 ? 1 : -1)) sides[side][found++] = static_cast<int>(i);
    }
  }
  return sides;
}();

/// The boundary faces of the marching cube round a lattice corner, and the sides of its polygons:
/// on each of the cube's six sides up to two, from face to face, that part object from background.
class MarchingCube {
 public:
  /// \param state  state(offset): the LatticeBits of the node at this offset from the corner, one
  ///        of kCubeFaces or of the cube's eight voxels.
  template <class State>
  explicit MarchingCube(const State& state) {
    for (std::size_t i = 0; i < 12; ++i) {
      crossed[i] = (state(kCubeFaces[i]) & kFaceCentre) != 0;
      count += crossed[i];
    }
    if (count < 3) return;
    for (const auto& side : kCubeSides) {
      std::array<int, 4> found{};
      int found_count = 0;
      for (const int i : side)
        if (crossed[static_cast<std::size_t>(i)])
          found[static_cast<std::size_t>(found_count++)] = i;
      if (found_count == 2) sides[side_count++] = {found[0], found[1]};
      if (found_count == 4) add_parted_sides(state, side);
    }
  }

  std::array<bool, 12> crossed{};              ///< of kCubeFaces
  std::array<std::array<int, 2>, 12> sides{};  ///< of kCubeFaces
  std::size_t side_count = 0;
  int count = 0;  ///< crossed ones

  /// visit(corners, size) for each polygon, its corners (of kCubeFaces) in order round it.
  template <class Visit>
  void for_each_polygon(const Visit& visit) const {
    std::array<bool, 12> seen{};
    if (count < 3) return;
    for (int first = 0; first < 12; ++first) {
      if (!crossed[static_cast<std::size_t>(first)] || seen[static_cast<std::size_t>(first)])
        continue;
      std::array<int, 12> polygon{};
      int size = 0;
      for (int i = first; i >= 0; i = next_corner(seen, i)) {
        seen[static_cast<std::size_t>(i)] = true;
        polygon[static_cast<std::size_t>(size++)] = i;
      }
      visit(polygon, size);
    }
  }

 private:
  /// The two sides that part the object's corners of an ambiguous side from each other.
  template <class State>
  void add_parted_sides(const State& state, const std::array<int, 4>& side) {
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const NodeOffset a = kCubeFaces[static_cast<std::size_t>(side[i])],
                         b = kCubeFaces[static_cast<std::size_t>(side[j])];
        // The voxel that both touch; parallel edges of the cube's side touch none.
        const auto join = [](std::int8_t p, std::int8_t q) -> std::int8_t {
          return p == q || q == 0 ? p : p == 0 ? q : std::int8_t{0};
        };
        const NodeOffset voxel = {join(a.x, b.x), join(a.y, b.y), join(a.z, b.z)};
        if (voxel.x == 0 || voxel.y == 0 || voxel.z == 0) continue;
        if (state(voxel) & kSolid) sides[side_count++] = {side[i], side[j]};
      }
  }

  /// A corner of the polygon that a side joins to corner i and that has not been seen; -1 for none.
  int next_corner(const std::array<bool, 12>& seen, int i) const {
    for (std::size_t s = 0; s < side_count; ++s) {
      const auto& [a, b] = sides[s];
      const int other = a == i ? b : b == i ? a : -1;
      if (other >= 0 && !seen[static_cast<std::size_t>(other)]) return other;
    }
    return -1;
  }
};

}  // namespace vasamesh

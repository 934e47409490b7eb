#pragma once

/// \file
/// The edge length that is asked for near the surface, a value a voxel in the bricks of the
/// indicator field.

#include <cstdint>

#include "types/indicator_field.h"

namespace vasamesh {

/// A ball in which edges are to be shorter than elsewhere, or the input is to stay as it is.
struct CarefulPlace {
  Vec3 centre;
  float radius = 2;  ///< voxel lengths
  float factor = 1;  ///< of the sizes; 0: the input's vertices stay
};

struct SizeView {
  FieldView field;          ///< its grid and table of bricks
  View<const float> sizes;  ///< 64 a brick, x fastest; voxel lengths
  float elsewhere = 1;      ///< where there is no brick
};

/// The size of the voxel that holds a point.
inline float size_at(const SizeView& view, const Vec3& p) {
  const float at[3] = {p.x * view.field.inverse_step[0], p.y * view.field.inverse_step[1],
                       p.z * view.field.inverse_step[2]};
  int node[3];
  for (int i = 0; i < 3; ++i) {
    if (!(at[i] >= 0 && at[i] < static_cast<float>(8 * view.field.grid[i]))) return view.elsewhere;
    node[i] = static_cast<int>(at[i]);
  }
  const std::int32_t brick =
      view.field.brick_at[view.field.cell_of({node[0] >> 3, node[1] >> 3, node[2] >> 3})];
  if (brick == kNoBrick) return view.elsewhere;
  const int x = node[0] >> 1 & 3, y = node[1] >> 1 & 3, z = node[2] >> 1 & 3;
  return view.sizes[std::size_t{64} * brick + (x + 4 * (y + 4 * z))];
}

}  // namespace vasamesh

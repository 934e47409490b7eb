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

  /// Whether a point lies in it, or up to `margin` beyond.
  bool holds(const Vec3& p, float margin = 0) const {
    const float reach = radius + margin;
    return squared_norm(p - centre) <= reach * reach;
  }
};

/// A place that reaches into a cell of a grid.
struct PlaceCell {
  std::uint64_t cell;
  std::uint32_t place;
};

/// Places and the cells that find them (stages/places.h).
struct PlaceView {
  View<const PlaceCell> cells;  ///< sorted by cell
  View<const CarefulPlace> places;
};

struct SizeView {
  FieldView field;          ///< its grid and table of bricks
  View<const float> sizes;  ///< 64 a brick, x fastest; voxel lengths
  float elsewhere = 1;      ///< where there is no brick
};

/// The entry of the voxel that holds a point, or the number of entries where there is no brick.
inline std::size_t size_cell(const FieldView& field, const Vec3& p) {
  constexpr std::size_t kCells = 64;
  const std::size_t none = field.coefficients.size / kBrickCells * kCells;
  const float at[3] = {p.x * field.inverse_step[0], p.y * field.inverse_step[1],
                       p.z * field.inverse_step[2]};
  int node[3];
  for (int i = 0; i < 3; ++i) {
    if (!(at[i] >= 0 && at[i] < static_cast<float>(8 * field.grid[i]))) return none;
    node[i] = static_cast<int>(at[i]);
  }
  const std::int32_t brick =
      field.brick_at[field.cell_of({node[0] >> 3, node[1] >> 3, node[2] >> 3})];
  if (brick == kNoBrick) return none;
  const int x = node[0] >> 1 & 3, y = node[1] >> 1 & 3, z = node[2] >> 1 & 3;
  return kCells * static_cast<std::size_t>(brick) + static_cast<std::size_t>(x + 4 * (y + 4 * z));
}

/// Edges longer than this times their size are split.
inline constexpr float kLongest = 4.0f / 3.0f;

/// The size of the voxel that holds a point.
inline float size_at(const SizeView& view, const Vec3& p) {
  const std::size_t cell = size_cell(view.field, p);
  return cell < view.sizes.size ? view.sizes[cell] : view.elsewhere;
}

}  // namespace vasamesh

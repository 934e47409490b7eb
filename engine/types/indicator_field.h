#pragma once

/// \file
/// The indicator function near the surface as one smooth function: the quadratic B-spline over the
/// cell lattice, whose nodes are half a voxel apart. It holds what the repair has changed, so that
/// its zero set follows the base surface. Positive inside, zero on the surface.
///
/// Positions are in voxel lengths (the geometric mean of the three spacings) from the padded
/// volume's corner: padded voxel units times the Scale.

#include <algorithm>
#include <array>
#include <cstdint>

#include "types/bricks.h"
#include "types/buffer.h"
#include "types/point_cloud.h"
#include "types/vec3.h"

namespace vasamesh {

/// Host memory or a device's: what a pass needs to evaluate the function.
struct FieldView {
  std::array<int, 3> grid{0, 0, 0};   ///< bricks of nodes along each axis
  View<const std::int32_t> brick_at;  ///< a brick of the grid (x fastest): its index or kNoBrick
  View<const float> coefficients;     ///< 512 a brick
  Scale step{0.5f, 0.5f, 0.5f};       ///< voxel lengths between nodes
  Scale inverse_step{2, 2, 2};

  /// The entry of `brick_at` for a brick in the grid.
  std::size_t cell_of(const BrickCoord& brick) const {
    return (static_cast<std::size_t>(brick.z) * grid[1] + brick.y) * grid[0] + brick.x;
  }
};

/// The function at one point.
struct FieldSample {
  float value = 0;
  Vec3 gradient;       ///< a voxel length; points inwards
  bool known = false;  ///< false where one of the 27 nodes is in no brick
};

/// Quadratic B-spline weights and their derivatives at t in [-1/2, 1/2] from the middle node.
struct SplineWeights {
  explicit SplineWeights(float t)
      : value{0.5f * ((0.5f - t) * (0.5f - t)), 0.75f - t * t, 0.5f * ((0.5f + t) * (0.5f + t))},
        slope{t - 0.5f, -2.0f * t, t + 0.5f} {}
  float value[3];
  float slope[3];
};

/// Four floats in a register: a function's value and its derivatives along x, y and z.
using ValueAndGradient = float __attribute__((vector_size(16)));

inline FieldSample sample_field(const FieldView& field, const Vec3& p) {
  const float at[3] = {p.x * field.inverse_step[0], p.y * field.inverse_step[1],
                       p.z * field.inverse_step[2]};
  int node[3];
  float t[3];
  for (int i = 0; i < 3; ++i) {
    if (!(at[i] >= 1 && at[i] < static_cast<float>(8 * field.grid[i] - 2))) return {};
    node[i] = static_cast<int>(at[i] + 0.5f);
    t[i] = at[i] - static_cast<float>(node[i]);
  }
  // The 27 nodes lie in two bricks at most along each axis: which, and where in them.
  const BrickCoord low = {(node[0] - 1) >> 3, (node[1] - 1) >> 3, (node[2] - 1) >> 3};
  const int along[3] = {((node[0] + 1) >> 3) - low.x, ((node[1] + 1) >> 3) - low.y,
                        ((node[2] + 1) >> 3) - low.z};
  const float* brick[8] = {};
  for (int k = 0; k <= along[2]; ++k)
    for (int j = 0; j <= along[1]; ++j)
      for (int i = 0; i <= along[0]; ++i) {
        const std::int32_t at_cell =
            field.brick_at[field.cell_of({low.x + i, low.y + j, low.z + k})];
        if (at_cell == kNoBrick) return {};
        brick[i + 2 * j + 4 * k] = &field.coefficients[std::size_t{kBrickCells} * at_cell];
      }
  const SplineWeights wx(t[0]), wy(t[1]), wz(t[2]);
  ValueAndGradient sum{};
  for (int k = 0; k < 3; ++k) {
    const int z = node[2] + k - 1;
    ValueAndGradient plane{};
    for (int j = 0; j < 3; ++j) {
      const int y = node[1] + j - 1;
      const int side = 2 * ((y >> 3) - low.y) + 4 * ((z >> 3) - low.z);
      const int row_cell = brick_cell(0, y & 7, z & 7);
      ValueAndGradient row{};
      for (int i = 0; i < 3; ++i) {
        const int x = node[0] + i - 1;
        const float c = brick[side + ((x >> 3) - low.x)][row_cell + (x & 7)];
        row += c * ValueAndGradient{wx.value[i], wx.slope[i], wx.value[i], wx.value[i]};
      }
      plane += row * ValueAndGradient{wy.value[j], wy.value[j], wy.slope[j], wy.value[j]};
    }
    sum += plane * ValueAndGradient{wz.value[k], wz.value[k], wz.value[k], wz.slope[k]};
  }
  return {sum[0],
          {sum[1] * field.inverse_step[0], sum[2] * field.inverse_step[1],
           sum[3] * field.inverse_step[2]},
          true};
}

/// Newton steps along the gradient onto the zero set (at most `steps`), none longer than `reach` in
/// all; they end within a thousandth of a voxel length. \return the sample at the end; `known` is
/// false when the point left the field, went farther than `reach` or did not come within 1 % of a
/// voxel length; `p` is then unspecified.
inline FieldSample project_to_surface(const FieldView& field, float reach, int steps, Vec3& p) {
  constexpr float kNear = 0.01f, kThere = 0.001f;
  const Vec3 start = p;
  FieldSample sample = sample_field(field, p);
  for (int step = 0; step < steps && sample.known; ++step) {
    const float squared = squared_norm(sample.gradient);
    if (!(squared > 0)) return {};
    if (sample.value * sample.value <= kThere * kThere * squared) return sample;
    p = p - (sample.value / squared) * sample.gradient;
    if (!(squared_norm(p - start) <= reach * reach)) return {};
    sample = sample_field(field, p);
  }
  if (!sample.known) return {};
  const float squared = squared_norm(sample.gradient);
  if (!(sample.value * sample.value <= kNear * kNear * squared)) return {};
  return sample;
}

}  // namespace vasamesh

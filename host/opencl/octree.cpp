/// Octree levels: kernels/octree.cl.

#include <algorithm>
#include <cmath>

#include "opencl/opencl_backend.h"

namespace vasamesh {

void OpenClBackend::octree_mark_unknown(const LevelView& level, bool whole,
                                        View<std::uint8_t> unknown) {
  launch("octree_mark_unknown", level.bricks.count, shape_.brick_items, level.bricks.neighbours,
         cl_int{whole}, unknown);
}

void OpenClBackend::poisson_splat(const LevelView& level, const PointIndex& index,
                                  const PointView& points, const Scale& scale, const Kernel& kernel,
                                  View<float> right_hand_side) {
  const float cell = std::ldexp(1.0f, level.exponent);  // voxels, exact
  cl_float4 side{};
  cl_int4 reach{};  // voxels
  for (std::size_t i = 0; i < 3; ++i) {
    side.s[i] = scale[i] * cell;
    const float width = std::max(std::max(kernel.thick, kernel.thin) / side.s[i], 1.0f);
    reach.s[i] = static_cast<int>(std::ceil((1.5f * width + 0.5f) * cell)) + 1;
  }
  const cl_float2 knots{{kernel.thin, kernel.thick}};
  launch("poisson_splat", level.bricks.count, shape_.brick_items, level.exponent, 1.0f / cell, side,
         reach, knots, level.bricks.coords, index.side, index.bricks, index.voxel_start,
         points.position, points.area, points.normal, points.thickness, right_hand_side);
}

void OpenClBackend::poisson_restrict(const LevelView& coarse, View<const std::int32_t> children,
                                     View<const float> fine_values, View<float> coarse_values) {
  launch("poisson_restrict", coarse.bricks.count, shape_.brick_items, children, fine_values,
         coarse_values);
}

void OpenClBackend::poisson_prolong(const LevelView& fine, View<const std::int32_t> parents,
                                    View<const float> coarse_values, View<float> fine_values) {
  launch("poisson_prolong", fine.bricks.count, shape_.brick_items, fine.bricks.coords, parents,
         coarse_values, fine_values);
}

}  // namespace vasamesh

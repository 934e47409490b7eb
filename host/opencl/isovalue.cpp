/// The spline at the samples and the local isovalue: kernels/isovalue.cl.

#include <cmath>

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

float cells_a_voxel(const LevelView& level) { return std::ldexp(1.0f, -level.exponent); }

}  // namespace

void OpenClBackend::poisson_sample_points(const LevelView& level, const PointIndex& index,
                                          const PointView& points, View<const float> coefficients,
                                          View<float> values) {
  launch("poisson_sample_points", level.bricks.count, shape_.brick_items, level.exponent,
         cells_a_voxel(level), level.bricks.coords, level.bricks.neighbours, index.side,
         index.bricks, index.voxel_start, points.position, coefficients, values);
}

void OpenClBackend::isovalue_splat(const LevelView& level, const PointIndex& index,
                                   const PointView& points, View<const float> weights,
                                   View<const float> values, View<float> numerator,
                                   View<float> denominator) {
  const int reach = static_cast<int>(2 * std::ldexp(1.0, level.exponent)) + 1;  // voxels
  launch("isovalue_splat", level.bricks.count, shape_.brick_items, level.exponent,
         cells_a_voxel(level), reach, level.bricks.coords, index.side, index.bricks,
         index.voxel_start, points.position, weights, values, numerator, denominator);
}

void OpenClBackend::isovalue_smooth(const LevelView& level, int axis, float tap,
                                    View<const float> in, View<float> out) {
  launch("isovalue_smooth", level.bricks.count, shape_.brick_items, level.bricks.neighbours, axis,
         tap, in, out);
}

void OpenClBackend::isovalue_divide(float fallback, View<const float> denominator,
                                    View<float> numerator) {
  launch("isovalue_divide", numerator.size / kBrickCells, shape_.brick_items, fallback, denominator,
         numerator);
}

void OpenClBackend::field_add(float factor, View<const float> b, View<float> a) {
  launch("field_add", a.size / kBrickCells, shape_.brick_items, factor, b, a);
}

}  // namespace vasamesh

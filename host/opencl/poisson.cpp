/// The conjugate gradient's passes: kernels/poisson.cl.

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

cl_float4 weights_of(const LevelView& level) {
  return {{level.weights[0], level.weights[1], level.weights[2], 0}};
}

}  // namespace

void OpenClBackend::poisson_apply(const LevelView& level, View<const std::uint8_t> unknown,
                                  View<const float> p, View<float> q, View<float> partial) {
  launch("poisson_apply", level.bricks.count, shape_.brick_items, level.bricks.neighbours,
         weights_of(level), unknown, p, q, partial);
}

void OpenClBackend::poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                                     View<const float> b, View<const float> x, View<float> r,
                                     View<float> partial) {
  launch("poisson_residual", level.bricks.count, shape_.brick_items, level.bricks.neighbours,
         weights_of(level), unknown, b, x, r, partial);
}

void OpenClBackend::poisson_update_solution(const LevelView& level, float alpha,
                                            View<const float> p, View<const float> q, View<float> x,
                                            View<float> r, View<float> partial) {
  launch("poisson_update_solution", level.bricks.count, shape_.brick_items, alpha, p, q, x, r,
         partial);
}

void OpenClBackend::poisson_update_direction(const LevelView& level, float beta,
                                             View<const float> r, View<float> p) {
  launch("poisson_update_direction", level.bricks.count, shape_.brick_items, beta, r, p);
}

}  // namespace vasamesh

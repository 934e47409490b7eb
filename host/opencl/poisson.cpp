/// The conjugate gradient's passes: kernels/poisson.cl.

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

cl_float4 weights_of(const LevelView& level) {
  return {{level.weights[0], level.weights[1], level.weights[2], 0}};
}

}  // namespace

void OpenClBackend::poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                                     View<const float> b, View<const float> x, View<float> r,
                                     View<float> p, View<float> b_square, View<float> r_square) {
  launch("poisson_residual", level.bricks.count, shape_.brick_items, level.bricks.neighbours,
         weights_of(level), unknown, b, x, r, p, b_square, r_square);
}

void OpenClBackend::poisson_energy(const LevelView& level, View<const std::uint8_t> unknown,
                                   View<const float> p, View<float> energy) {
  launch("poisson_energy", level.bricks.count, shape_.brick_items, level.bricks.neighbours,
         weights_of(level), unknown, p, energy);
}

void OpenClBackend::poisson_update_solution(const LevelView& level,
                                            View<const std::uint8_t> unknown, float alpha,
                                            View<const float> p, View<float> x, View<float> r,
                                            View<float> r_square) {
  launch("poisson_update_solution", level.bricks.count, shape_.brick_items, level.bricks.neighbours,
         weights_of(level), unknown, alpha, p, x, r, r_square);
}

void OpenClBackend::poisson_update_direction(const LevelView& level, float beta,
                                             View<const float> r, View<float> p) {
  launch("poisson_update_direction", level.bricks.count, shape_.brick_items, beta, r, p);
}

}  // namespace vasamesh

/// The conjugate gradient's passes (eq. 2 of the paper on one level of bricks).

#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

/// Sum of 512 products in the order that the contract states.
float brick_dot(const float* a, const float* b) {
  float lane[8] = {};
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const int c = brick_cell(x, y, z);
        lane[x] += a[c] * b[c];
      }
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/// A brick with one layer of face neighbours round it.
struct Halo {
  float value[10][10][10];
};

void gather(const BrickView& bricks, std::size_t brick, const float* field, Halo& halo) {
  const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
  const auto from = [&](int dx, int dy, int dz) -> const float* {
    const std::int32_t b = near[brick_neighbour(dx, dy, dz)];
    return b == kNoBrick ? nullptr : field + std::size_t{kBrickCells} * b;
  };
  const float* own = from(0, 0, 0);
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) halo.value[z + 1][y + 1][x + 1] = own[brick_cell(x, y, z)];
  const float *xl = from(-1, 0, 0), *xh = from(1, 0, 0), *yl = from(0, -1, 0), *yh = from(0, 1, 0),
              *zl = from(0, 0, -1), *zh = from(0, 0, 1);
  for (int b = 0; b < 8; ++b)
    for (int a = 0; a < 8; ++a) {
      halo.value[b + 1][a + 1][0] = xl ? xl[brick_cell(7, a, b)] : 0;
      halo.value[b + 1][a + 1][9] = xh ? xh[brick_cell(0, a, b)] : 0;
      halo.value[b + 1][0][a + 1] = yl ? yl[brick_cell(a, 7, b)] : 0;
      halo.value[b + 1][9][a + 1] = yh ? yh[brick_cell(a, 0, b)] : 0;
      halo.value[0][b + 1][a + 1] = zl ? zl[brick_cell(a, b, 7)] : 0;
      halo.value[9][b + 1][a + 1] = zh ? zh[brick_cell(a, b, 0)] : 0;
    }
}

/// out = A p on the whole brick, unmasked.
void apply_brick(const LevelView& level, std::size_t brick, const float* p, float* out) {
  Halo h;
  gather(level.bricks, brick, p, h);
  const float wx = level.weights[0], wy = level.weights[1], wz = level.weights[2];
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const float two = 2.0f * h.value[z + 1][y + 1][x + 1];
        const float tx = (two - h.value[z + 1][y + 1][x]) - h.value[z + 1][y + 1][x + 2];
        const float ty = (two - h.value[z + 1][y][x + 1]) - h.value[z + 1][y + 2][x + 1];
        const float tz = (two - h.value[z][y + 1][x + 1]) - h.value[z + 2][y + 1][x + 1];
        out[brick_cell(x, y, z)] = (wx * tx + wy * ty) + wz * tz;
      }
}

constexpr std::size_t kGrain = 8;  // bricks a task takes

}  // namespace

void TbbBackend::poisson_apply(const LevelView& level, View<const std::uint8_t> unknown,
                               View<const float> p, View<float> q, View<float> partial) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    float* out = q.data() + first;
    apply_brick(level, brick, p.data(), out);
    for (int c = 0; c < kBrickCells; ++c) out[c] = unknown[first + c] ? out[c] : 0.0f;
    partial[brick] = brick_dot(p.data() + first, out);
  });
}

void TbbBackend::poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                                  View<const float> b, View<const float> x, View<float> r,
                                  View<float> partial) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    float* out = r.data() + first;
    apply_brick(level, brick, x.data(), out);
    for (int c = 0; c < kBrickCells; ++c) out[c] = unknown[first + c] ? b[first + c] - out[c] : 0.0f;
    partial[brick] = brick_dot(out, out);
  });
}

void TbbBackend::poisson_update_solution(const LevelView& level, float alpha, View<const float> p,
                                         View<const float> q, View<float> x, View<float> r,
                                         View<float> partial) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    for (std::size_t c = first; c < first + kBrickCells; ++c) {
      x[c] += alpha * p[c];
      r[c] -= alpha * q[c];
    }
    partial[brick] = brick_dot(r.data() + first, r.data() + first);
  });
}

void TbbBackend::poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                          View<float> p) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    for (std::size_t c = first; c < first + kBrickCells; ++c) p[c] = r[c] + beta * p[c];
  });
}

}  // namespace vasamesh

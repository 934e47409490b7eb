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

/// A brick of a field and its face neighbours, by rows of eight; zeros where there is none.
struct BrickRows {
  BrickRows(const BrickView& bricks, std::size_t brick, const float* field) {
    static constexpr float kZeros[kBrickCells] = {};
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    const auto from = [&](int dx, int dy, int dz) {
      const std::int32_t b = near[brick_neighbour(dx, dy, dz)];
      return b == kNoBrick ? kZeros : field + std::size_t{kBrickCells} * b;
    };
    own = from(0, 0, 0);
    left = from(-1, 0, 0), right = from(1, 0, 0);
    front = from(0, -1, 0), back = from(0, 1, 0);
    below = from(0, 0, -1), above = from(0, 0, 1);
  }

  /// The row at (y, z); one of the two may be -1 or 8.
  const float* row(int y, int z) const {
    const float* brick = y < 0 ? front : y > 7 ? back : z < 0 ? below : z > 7 ? above : own;
    return brick + brick_cell(0, y & 7, z & 7);
  }

  const float *own, *left, *right, *front, *back, *below, *above;
};

/// out = A p on the whole brick, unmasked.
void apply_brick(const LevelView& level, std::size_t brick, const float* p, float* out) {
  const BrickRows rows(level.bricks, brick, p);
  const float wx = level.weights[0], wy = level.weights[1], wz = level.weights[2];
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y) {
      const float *own = rows.row(y, z), *front = rows.row(y - 1, z), *back = rows.row(y + 1, z),
                  *below = rows.row(y, z - 1), *above = rows.row(y, z + 1);
      float along[10];
      along[0] = rows.left[brick_cell(7, y, z)];
      for (int x = 0; x < 8; ++x) along[x + 1] = own[x];
      along[9] = rows.right[brick_cell(0, y, z)];
      float* result = out + brick_cell(0, y, z);
      for (int x = 0; x < 8; ++x) {
        const float two = 2.0f * own[x];
        const float tx = (two - along[x]) - along[x + 2];
        const float ty = (two - front[x]) - back[x];
        const float tz = (two - below[x]) - above[x];
        result[x] = (wx * tx + wy * ty) + wz * tz;
      }
    }
}

/// Clears the cells that are not unknown.
void mask(const std::uint8_t* unknown, float* values) {
  for (int c = 0; c < kBrickCells; ++c) values[c] = unknown[c] ? values[c] : 0.0f;
}

constexpr std::size_t kGrain = 8;  // bricks a task takes

}  // namespace

void TbbBackend::poisson_apply(const LevelView& level, View<const std::uint8_t> unknown,
                               View<const float> p, View<float> q, View<float> partial) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    float* out = q.data() + first;
    apply_brick(level, brick, p.data(), out);
    mask(unknown.data() + first, out);
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
    for (int c = 0; c < kBrickCells; ++c) out[c] = b[first + c] - out[c];
    mask(unknown.data() + first, out);
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

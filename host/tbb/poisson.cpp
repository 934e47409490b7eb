/// The conjugate gradient's passes (eq. 2 of the paper on one level of bricks).

#include "tbb/rows.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

/// Calls use(c, field's row, row of A field where unknown) for the rows of a brick in order; c is a
/// row's first cell.
template <class Use>
void for_image_rows(const LevelView& level, std::size_t brick, const std::uint8_t* unknown,
                    const float* field, const Use& use) {
  const BrickRows rows(level.bricks, brick, field);
  const float wx = level.weights[0], wy = level.weights[1], wz = level.weights[2];
  for (int z = 0; z < 8; ++z) {
    const float* below = z > 0 ? rows.own + brick_cell(0, 0, z - 1) : rows.below + 64 * 7;
    const float* above = z < 7 ? rows.own + brick_cell(0, 0, z + 1) : rows.above;
    Row front = load_row(rows.front + brick_cell(0, 7, z));
    Row own = load_row(rows.own + brick_cell(0, 0, z));
    for (int y = 0; y < 8; ++y) {
      const int c = brick_cell(0, y, z);
      const Row back = load_row(y < 7 ? rows.own + c + 8 : rows.back + brick_cell(0, 0, z));
      const Row two = 2.0f * own;
      const Row tx = (two - shifted_up(own, rows.left[c + 7])) - shifted_down(own, rows.right[c]);
      const Row ty = (two - front) - back;
      const Row tz = (two - load_row(below + 8 * y)) - load_row(above + 8 * y);
      use(c, own, where(load_mask(unknown + c), (wx * tx + wy * ty) + wz * tz));
      front = own;
      own = back;
    }
  }
}

constexpr std::size_t kGrain = 8;  // bricks a task takes

}  // namespace

void TbbBackend::poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                                  View<const float> b, View<const float> x, View<float> r,
                                  View<float> p, View<float> b_square, View<float> r_square) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    const std::uint8_t* mask = unknown.data() + first;
    Row b_sum{}, r_sum{};
    for_image_rows(level, brick, mask, x.data(), [&](int c, const Row&, const Row& image) {
      const Row wanted = where(load_mask(mask + c), load_row(b.data() + first + c));
      const Row rest = wanted - image;
      store_row(r.data() + first + c, rest);
      store_row(p.data() + first + c, rest);
      b_sum += wanted * wanted;
      r_sum += rest * rest;
    });
    b_square[brick] = sum_of_row(b_sum);
    r_square[brick] = sum_of_row(r_sum);
  });
}

void TbbBackend::poisson_energy(const LevelView& level, View<const std::uint8_t> unknown,
                                View<const float> p, View<float> energy) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    Row sum{};
    for_image_rows(level, brick, unknown.data() + brick * kBrickCells, p.data(),
                   [&](int, const Row& own, const Row& image) { sum += own * image; });
    energy[brick] = sum_of_row(sum);
  });
}

void TbbBackend::poisson_update_solution(const LevelView& level, View<const std::uint8_t> unknown,
                                         float alpha, View<const float> p, View<float> x,
                                         View<float> r, View<float> r_square) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    float *solution = x.data() + first, *residual = r.data() + first;
    Row sum{};
    for_image_rows(level, brick, unknown.data() + first, p.data(),
                   [&](int c, const Row& own, const Row& image) {
                     store_row(solution + c, load_row(solution + c) + alpha * own);
                     const Row rest = load_row(residual + c) - alpha * image;
                     store_row(residual + c, rest);
                     sum += rest * rest;
                   });
    r_square[brick] = sum_of_row(sum);
  });
}

void TbbBackend::poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                          View<float> p) {
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::size_t first = brick * kBrickCells;
    for (std::size_t c = first; c < first + kBrickCells; c += 8)
      store_row(p.data() + c, load_row(r.data() + c) + beta * load_row(p.data() + c));
  });
}

}  // namespace vasamesh

#include "stages/field.h"

#include <algorithm>
#include <cmath>

#include "backend/ranges.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 8;  // bricks a task takes

/// The values of a brick's neighbour; null where there is none.
const float* brick_values(const BrickView& bricks, const float* values, std::size_t brick,
                          int neighbour) {
  const std::int32_t other = bricks.neighbours[27 * brick + static_cast<std::size_t>(neighbour)];
  return other == kNoBrick ? nullptr : values + std::size_t{kBrickCells} * other;
}

/// coefficients -= an eighth of the second difference of `count` values.
void subtract_second_differences(const float* own, const float* low, const float* high, int count,
                                 float* coefficients) {
  for (int i = 0; i < count; ++i) coefficients[i] -= 0.125f * ((low[i] + high[i]) - 2.0f * own[i]);
}

/// The same along an axis of a run of eight layers, `stride` values each; nothing where a neighbour
/// is not there. \param below, above  the runs before and behind; may be null.
void subtract_along(const float* own, const float* below, const float* above, int stride,
                    float* coefficients) {
  const int last = 7 * stride;
  if (below) subtract_second_differences(own, below + last, own + stride, stride, coefficients);
  subtract_second_differences(own + stride, own, own + 2 * stride, 6 * stride,
                              coefficients + stride);
  if (above)
    subtract_second_differences(own + last, own + last - stride, above, stride,
                                coefficients + last);
}

void brick_coefficients(const BrickView& bricks, const float* values, std::size_t brick,
                        float* coefficients) {
  const float* own = values + kBrickCells * brick;
  std::copy_n(own, kBrickCells, coefficients);
  for (int axis = 0; axis < 3; ++axis) {
    const int along[3] = {axis == 0, axis == 1, axis == 2};
    const float* below =
        brick_values(bricks, values, brick, brick_neighbour(-along[0], -along[1], -along[2]));
    const float* above =
        brick_values(bricks, values, brick, brick_neighbour(along[0], along[1], along[2]));
    const int stride = 1 << (3 * axis);
    for (int run = 0; run < kBrickCells; run += 8 * stride)
      subtract_along(own + run, below ? below + run : nullptr, above ? above + run : nullptr,
                     stride, coefficients + run);
  }
}

}  // namespace

FieldView IndicatorField::view() const {
  return {grid,
          brick_at.view(),
          coefficients.view(),
          step,
          {1.0f / step[0], 1.0f / step[1], 1.0f / step[2]}};
}

IndicatorField make_field(Backend& backend, const Lattice& lattice, const std::array<int, 3>& size,
                          const Scale& scale) {
  IndicatorField field;
  for (std::size_t i = 0; i < 3; ++i) {
    field.grid[i] = size[i] / 4;
    field.step[i] = 0.5f * scale[i];
  }
  const BrickView bricks = lattice.bricks.view();
  const auto coords = backend.on_host(bricks.coords);
  field.brick_at = Buffer<std::int32_t>(
      backend, static_cast<std::size_t>(field.grid[0]) * field.grid[1] * field.grid[2]);
  const std::span<std::int32_t> table = backend.on_host(field.brick_at.view());
  std::fill(table.begin(), table.end(), kNoBrick);
  for (std::size_t b = 0; b < bricks.count; ++b)
    table[field.view().cell_of(coords[b])] = static_cast<std::int32_t>(b);

  const auto neighbours = backend.on_host(bricks.neighbours);
  field.neighbours = Buffer<std::int32_t>(backend, neighbours.size());
  std::copy(neighbours.begin(), neighbours.end(), backend.on_host(field.neighbours.view()).begin());
  field.coefficients = Buffer<float>(backend, bricks.count * kBrickCells);
  const float* values = backend.on_host(View<const float>(lattice.values.view())).data();
  float* coefficients = backend.on_host(field.coefficients.view()).data();
  for_each_index(backend, bricks.count, kGrain, [&](std::size_t b) {
    brick_coefficients(bricks, values, b, coefficients + kBrickCells * b);
  });
  return field;
}

}  // namespace vasamesh

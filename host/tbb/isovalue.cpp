/// The spline at the samples, and the local isovalue: the area-weighted mean of the field at the
/// samples under a normalised kernel.

#include <array>
#include <cmath>

#include "tbb/point_gather.h"
#include "tbb/rows.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 8;  // bricks a task takes

/// Voxels of a brick of the level.
void own_voxels(const LevelView& level, const BrickCoord& coord, VoxelRange (&box)[3]) {
  box[0] = brick_voxels(level.exponent, coord.x);
  box[1] = brick_voxels(level.exponent, coord.y);
  box[2] = brick_voxels(level.exponent, coord.z);
}

/// The three cells round a position along one axis (in cells from the brick's corner) and their
/// weights.
struct Taps {
  explicit Taps(float p) {
    const float nearest = std::floor(p);
    first = static_cast<int>(nearest) - 1;
    const float t = p - (nearest + 0.5f);  // -0.5 .. 0.5 from the nearest cell's centre
    weight[0] = 0.5f * ((0.5f - t) * (0.5f - t));
    weight[1] = 0.75f - t * t;
    weight[2] = 0.5f * ((0.5f + t) * (0.5f + t));
  }
  /// The weights of a brick's eight cells.
  Row row() const {
    constexpr Row kCell = {0, 1, 2, 3, 4, 5, 6, 7};
    const Row i = kCell - static_cast<float>(first);
    return i == 0.0f   ? weight[0] + Row{}
           : i == 1.0f ? weight[1] + Row{}
           : i == 2.0f ? weight[2] + Row{}
                       : Row{};
  }

  int first;
  float weight[3];
};

float spline_value(const std::int32_t* near, const float* coefficients, const Taps (&taps)[3]) {
  float sum = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      float row = 0;
      for (int i = 0; i < 3; ++i) {
        const int x = taps[0].first + i + 8, y = taps[1].first + j + 8, z = taps[2].first + k + 8;
        const std::int32_t from = near[(x >> 3) + 3 * ((y >> 3) + 3 * (z >> 3))];
        if (from == kNoBrick) continue;
        row += taps[0].weight[i] *
               coefficients[std::size_t{kBrickCells} * from + brick_cell(x & 7, y & 7, z & 7)];
      }
      sum += (taps[1].weight[j] * taps[2].weight[k]) * row;
    }
  return sum;
}

}  // namespace

void TbbBackend::poisson_sample_points(const LevelView& level, const PointIndex& index,
                                       const PointView& points, View<const float> coefficients,
                                       View<float> values) {
  const float per_voxel = std::ldexp(1.0f, -level.exponent);
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickCoord coord = level.bricks.coords[brick];
    VoxelRange box[3];
    own_voxels(level, coord, box);
    const std::int32_t* near = level.bricks.neighbours.data() + 27 * brick;
    visit_points(
        index, level.exponent, brick, coord, box, [&](std::uint32_t from, std::uint32_t to) {
          for (std::uint32_t p = from; p < to; ++p) {
            const auto tap = [&](int i) {
              return Taps((points.position[i][p] - static_cast<float>(box[i].first)) * per_voxel);
            };
            const Taps taps[3] = {tap(0), tap(1), tap(2)};
            values[p] = spline_value(near, coefficients.data(), taps);
          }
        });
  });
}

void TbbBackend::isovalue_splat(const LevelView& level, const PointIndex& index,
                                const PointView& points, View<const float> weights,
                                View<const float> values, View<float> numerator,
                                View<float> denominator) {
  const float per_voxel = std::ldexp(1.0f, -level.exponent);
  const int reach = static_cast<int>(2 * std::ldexp(1.0, level.exponent)) + 1;  // voxels
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickCoord coord = level.bricks.coords[brick];
    VoxelRange box[3];
    own_voxels(level, coord, box);
    float corner[3];
    for (int i = 0; i < 3; ++i) {
      corner[i] = static_cast<float>(box[i].first);
      box[i] = {box[i].first - reach, box[i].last + reach};
    }
    float* num = numerator.data() + kBrickCells * brick;
    float* den = denominator.data() + kBrickCells * brick;
    std::fill_n(num, kBrickCells, 0.0f);
    std::fill_n(den, kBrickCells, 0.0f);
    const auto add = [&](std::uint32_t p) {
      const float weight = weights[p];
      if (weight == 0) return;
      const auto tap = [&](int i) { return Taps((points.position[i][p] - corner[i]) * per_voxel); };
      const Taps x = tap(0), y = tap(1), z = tap(2);
      if (x.first < -2 || x.first > 7) return;
      const Row along = x.row();
      for (int k = std::max(z.first, 0); k < std::min(z.first + 3, 8); ++k)
        for (int j = std::max(y.first, 0); j < std::min(y.first + 3, 8); ++j) {
          const Row w = weight * (along * (y.weight[j - y.first] * z.weight[k - z.first]));
          const int row = brick_cell(0, j, k);
          store_row(num + row, load_row(num + row) + w * values[p]);
          store_row(den + row, load_row(den + row) + w);
        }
    };
    visit_points(index, level.exponent, brick, coord, box,
                 [&](std::uint32_t from, std::uint32_t to) {
                   for (std::uint32_t p = from; p < to; ++p) add(p);
                 });
  });
}

void TbbBackend::isovalue_smooth(const LevelView& level, int axis, float tap, View<const float> in,
                                 View<float> out) {
  const float keep = 1.0f - 2.0f * tap;
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickRows rows(level.bricks, brick, in.data());
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y) {
        const int c = brick_cell(0, y, z);
        const Row own = load_row(rows.own + c);
        Row low, high;
        if (axis == 0) {
          low = shifted_up(own, rows.left[c + 7]);
          high = shifted_down(own, rows.right[c]);
        } else {
          low = rows.row(y - (axis == 1), z - (axis == 2));
          high = rows.row(y + (axis == 1), z + (axis == 2));
        }
        store_row(out.data() + kBrickCells * brick + c, keep * own + tap * (low + high));
      }
  });
}

void TbbBackend::isovalue_divide(float fallback, View<const float> denominator,
                                 View<float> numerator) {
  constexpr float kSmall = 1e-4f;
  for_each(numerator.size / kBrickCells, 64, [=](std::size_t brick) {
    for (std::size_t c = kBrickCells * brick; c < kBrickCells * (brick + 1); ++c)
      numerator[c] = (numerator[c] + kSmall * fallback) / (denominator[c] + kSmall);
  });
}

void TbbBackend::field_add(float factor, View<const float> b, View<float> a) {
  for_each(a.size / kBrickCells, 64, [=](std::size_t brick) {
    for (std::size_t c = kBrickCells * brick; c < kBrickCells * (brick + 1); ++c)
      a[c] += factor * b[c];
  });
}

}  // namespace vasamesh

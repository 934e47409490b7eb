/// The spline at the samples, and the local isovalue: the area-weighted mean of the field at the
/// samples under a normalised kernel.

#include <array>
#include <cmath>

#include "tbb/point_gather.h"
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
                                const PointView& points, View<const float> values,
                                View<float> numerator, View<float> denominator) {
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
    visit_points(
        index, level.exponent, brick, coord, box, [&](std::uint32_t from, std::uint32_t to) {
          for (std::uint32_t p = from; p < to; ++p) {
            const float ax = points.area[0][p], ay = points.area[1][p], az = points.area[2][p];
            const float area = std::sqrt((ax * ax + ay * ay) + az * az);
            const auto tap = [&](int i) {
              return Taps((points.position[i][p] - corner[i]) * per_voxel);
            };
            const Taps taps[3] = {tap(0), tap(1), tap(2)};
            for (int k = 0; k < 3; ++k)
              for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 3; ++i) {
                  const int x = taps[0].first + i, y = taps[1].first + j, z = taps[2].first + k;
                  if ((x | y | z) < 0 || x > 7 || y > 7 || z > 7) continue;
                  const float w =
                      area * (taps[0].weight[i] * (taps[1].weight[j] * taps[2].weight[k]));
                  num[brick_cell(x, y, z)] += w * values[p];
                  den[brick_cell(x, y, z)] += w;
                }
          }
        });
  });
}

void TbbBackend::isovalue_smooth(const LevelView& level, int axis, float tap, View<const float> in,
                                 View<float> out) {
  const int stride = axis == 0 ? 1 : axis == 1 ? 8 : 64;
  const float own = 1.0f - 2.0f * tap;
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const std::int32_t* near = level.bricks.neighbours.data() + 27 * brick;
    const int step = axis == 0 ? 1 : axis == 1 ? 3 : 9;
    const std::int32_t below = near[13 - step], above = near[13 + step];
    for (int c = 0; c < kBrickCells; ++c) {
      const int along = c / stride & 7;
      const auto value = [&](std::int32_t b, int cell) {
        return b == kNoBrick ? 0.0f : in[std::size_t{kBrickCells} * b + cell];
      };
      const auto self = static_cast<std::int32_t>(brick);
      const float low = along > 0 ? value(self, c - stride) : value(below, c + 7 * stride);
      const float high = along < 7 ? value(self, c + stride) : value(above, c - 7 * stride);
      out[kBrickCells * brick + c] = own * in[kBrickCells * brick + c] + tap * (low + high);
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

void TbbBackend::field_subtract(View<float> a, View<const float> b) {
  for_each(a.size / kBrickCells, 64, [=](std::size_t brick) {
    for (std::size_t c = kBrickCells * brick; c < kBrickCells * (brick + 1); ++c) a[c] -= b[c];
  });
}

}  // namespace vasamesh

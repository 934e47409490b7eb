/// Octree levels: unknown cells, splatting and divergence (eq. 3 and 4 of the paper), restriction
/// and prolongation of quadratic B-splines.

#include <array>
#include <cmath>

#include "tbb/point_gather.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 4;  // bricks a task takes

/// The B-spline of knots `width` cells at the 8 cells of a brick along one axis, and its
/// difference over each cell; `p` is the point's position from the brick's corner, in cells.
struct AxisWeights {
  AxisWeights(float p, float width) {
    const float inverse = 1.0f / width;
    const float reach = 1.5f * width + 0.5f;
    first = std::max(0, static_cast<int>(std::ceil(p - reach - 0.5f)));
    last = std::min(8, static_cast<int>(std::floor(p + reach - 0.5f)) + 1);
    float face[9];
    for (int c = 0; c < 9; ++c) face[c] = bspline((static_cast<float>(c) - p) * inverse);
    for (int c = 0; c < 8; ++c)
      value[c] = bspline((static_cast<float>(c) + 0.5f - p) * inverse) * inverse;
    for (int c = 0; c < 8; ++c) difference[c] = (face[c + 1] - face[c]) * inverse;
  }
  float value[8], difference[8];
  int first, last;
};

/// Whether the kernel of a point reaches a brick's 8 cells along an axis.
bool reaches(float p, float width) {
  const float reach = 1.5f * width + 0.5f;
  return p > 0.5f - reach && p < 7.5f + reach;
}

/// Cells of fine bricks round a coarse cell, along one axis: brick (0..3 of `children`) and cell.
struct FineCell {
  int brick, cell;
};

FineCell fine_cell(int coarse_cell, int tap) {
  const int fine = 2 * coarse_cell - 1 + tap + 8;  // from the corner of fine brick 2 B - 1
  return {fine >> 3, fine & 7};
}

constexpr float kRestrict[4] = {0.25f, 0.75f, 0.75f, 0.25f};

}  // namespace

void TbbBackend::octree_mark_unknown(const LevelView& level, bool whole,
                                     View<std::uint8_t> unknown) {
  for_each(level.bricks.count, 64, [=](std::size_t brick) {
    const std::int32_t* near = level.bricks.neighbours.data() + 27 * brick;
    const auto missing = [&](int dx, int dy, int dz) {
      return !whole && near[brick_neighbour(dx, dy, dz)] == kNoBrick;
    };
    const bool lost[6] = {missing(-1, 0, 0), missing(1, 0, 0),  missing(0, -1, 0),
                          missing(0, 1, 0),  missing(0, 0, -1), missing(0, 0, 1)};
    std::uint8_t* out = unknown.data() + kBrickCells * brick;
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          out[brick_cell(x, y, z)] =
              !((lost[0] && x == 0) || (lost[1] && x == 7) || (lost[2] && y == 0) ||
                (lost[3] && y == 7) || (lost[4] && z == 0) || (lost[5] && z == 7));
  });
}

void TbbBackend::poisson_splat(const LevelView& level, const PointIndex& index,
                               const PointView& points, const Scale& scale, const Kernel& kernel,
                               View<float> right_hand_side) {
  const float cell = std::ldexp(1.0f, level.exponent);  // voxels, exact
  const float per_voxel = 1.0f / cell;
  const std::array<float, 3> side = {scale[0] * cell, scale[1] * cell, scale[2] * cell};
  std::array<int, 3> reach;  // voxels
  for (int i = 0; i < 3; ++i) {
    const float width = std::max(kernel.thick, kernel.thin) / side[i];
    reach[i] = static_cast<int>(std::ceil((1.5f * std::max(width, 1.0f) + 0.5f) * cell)) + 1;
  }
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickCoord coord = level.bricks.coords[brick];
    const int brick_at[3] = {coord.x, coord.y, coord.z};
    VoxelRange box[3];
    float corner[3];
    for (int i = 0; i < 3; ++i) {
      const VoxelRange own = brick_voxels(level.exponent, brick_at[i]);
      const int low = ((own.first >> 3) - 1) * 8, high = low + 8 * index.side;
      box[i] = {std::max(own.first - reach[i], low), std::min(own.last + reach[i], high)};
      corner[i] = static_cast<float>(own.first);
    }
    float sum[kBrickCells] = {};
    visit_points(
        index, level.exponent, brick, coord, box, [&](std::uint32_t from, std::uint32_t to) {
          for (std::uint32_t p = from; p < to; ++p) {
            const float width = kernel.thin + (kernel.thick - kernel.thin) * points.thickness[p];
            const auto weights = [&](int i) {
              return AxisWeights((points.position[i][p] - corner[i]) * per_voxel,
                                 std::max(width / side[i], 1.0f));
            };
            const AxisWeights wx = weights(0), wy = weights(1), wz = weights(2);
            if (wx.first >= wx.last || wy.first >= wy.last || wz.first >= wz.last) continue;
            const float ax = points.area[0][p] / side[0], ay = points.area[1][p] / side[1],
                        az = points.area[2][p] / side[2];
            for (int z = wz.first; z < wz.last; ++z)
              for (int y = wy.first; y < wy.last; ++y) {
                const float along = ax * (wy.value[y] * wz.value[z]);
                const float across =
                    ay * (wy.difference[y] * wz.value[z]) + az * (wy.value[y] * wz.difference[z]);
                float* row = sum + brick_cell(0, y, z);
                for (int x = 0; x < 8; ++x)
                  row[x] += along * wx.difference[x] + across * wx.value[x];
              }
          }
        });
    std::copy_n(sum, kBrickCells, right_hand_side.data() + kBrickCells * brick);
  });
}

void TbbBackend::poisson_restrict(const LevelView& coarse, View<const std::int32_t> children,
                                  View<const float> fine_values, View<float> coarse_values) {
  for_each(coarse.bricks.count, kGrain, [=](std::size_t brick) {
    const std::int32_t* fine = children.data() + 64 * brick;
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
          float sum = 0;
          for (int k = 0; k < 4; ++k)
            for (int j = 0; j < 4; ++j)
              for (int i = 0; i < 4; ++i) {
                const FineCell fx = fine_cell(x, i), fy = fine_cell(y, j), fz = fine_cell(z, k);
                const std::int32_t from = fine[fx.brick + 4 * (fy.brick + 4 * fz.brick)];
                if (from == kNoBrick) continue;
                sum += (kRestrict[i] * kRestrict[j] * kRestrict[k]) *
                       fine_values[std::size_t{kBrickCells} * from +
                                   brick_cell(fx.cell, fy.cell, fz.cell)];
              }
          coarse_values[kBrickCells * brick + brick_cell(x, y, z)] = sum;
        }
  });
}

void TbbBackend::poisson_prolong(const LevelView& fine, View<const std::int32_t> parents,
                                 View<const float> coarse_values, View<float> fine_values) {
  for_each(fine.bricks.count, kGrain, [=](std::size_t brick) {
    const std::int32_t* near = parents.data() + 27 * brick;
    const BrickCoord coord = fine.bricks.coords[brick];
    const int base[3] = {(coord.x & 1) * 4 - 1, (coord.y & 1) * 4 - 1, (coord.z & 1) * 4 - 1};
    // The 6^3 coarse cells over the brick, then refined an axis at a time.
    float c[6][6][6], cx[6][6][8], cy[6][8][8];
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 6; ++x) {
          const int gx = base[0] + x + 8, gy = base[1] + y + 8, gz = base[2] + z + 8;
          const std::int32_t from = near[(gx >> 3) + 3 * ((gy >> 3) + 3 * (gz >> 3))];
          c[z][y][x] = from == kNoBrick ? 0.0f
                                        : coarse_values[std::size_t{kBrickCells} * from +
                                                        brick_cell(gx & 7, gy & 7, gz & 7)];
        }
    // Fine cell 2 i: 3/4 of coarse i and 1/4 of i - 1; fine cell 2 i + 1: 3/4 of i, 1/4 of i + 1.
    const auto refine = [](float own, float other) { return 0.75f * own + 0.25f * other; };
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x) {
          const int own = (x >> 1) + 1;
          cx[z][y][x] = refine(c[z][y][own], c[z][y][x & 1 ? own + 1 : own - 1]);
        }
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 8; ++y) {
        const int own = (y >> 1) + 1, other = y & 1 ? own + 1 : own - 1;
        for (int x = 0; x < 8; ++x) cy[z][y][x] = refine(cx[z][own][x], cx[z][other][x]);
      }
    float* out = fine_values.data() + kBrickCells * brick;
    for (int z = 0; z < 8; ++z) {
      const int own = (z >> 1) + 1, other = z & 1 ? own + 1 : own - 1;
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          out[brick_cell(x, y, z)] = refine(cy[own][y][x], cy[other][y][x]);
    }
  });
}

}  // namespace vasamesh

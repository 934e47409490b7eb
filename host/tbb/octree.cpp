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

/// Adding points to the right-hand side of one brick.
struct Splat {
  PointView points;
  Kernel kernel;
  float per_voxel;              ///< cells a voxel
  std::array<float, 3> side;    ///< of a cell, voxel lengths
  std::array<float, 3> corner;  ///< of the brick, voxels

  void add(std::uint32_t p, float* sum) const {
    const float knots = kernel.at(points.thickness[p]);
    float at[3], width[3];
    for (std::size_t i = 0; i < 3; ++i) {
      at[i] = (points.position[i][p] - corner[i]) * per_voxel;
      width[i] = std::max(knots / side[i], 1.0f);
    }
    if (!reaches(at[0], width[0]) || !reaches(at[1], width[1]) || !reaches(at[2], width[2])) return;
    const AxisWeights wx(at[0], width[0]), wy(at[1], width[1]), wz(at[2], width[2]);
    const float nx = points.normal[0][p], ny = points.normal[1][p], nz = points.normal[2][p];
    const float weight = (points.area[0][p] * nx + points.area[1][p] * ny) + points.area[2][p] * nz;
    const float ax = weight * nx / side[0], ay = weight * ny / side[1], az = weight * nz / side[2];
    for (int z = wz.first; z < wz.last; ++z)
      for (int y = wy.first; y < wy.last; ++y) {
        const float along = ax * (wy.value[y] * wz.value[z]);
        const float across =
            ay * (wy.difference[y] * wz.value[z]) + az * (wy.value[y] * wz.difference[z]);
        float* row = sum + brick_cell(0, y, z);
        for (int x = 0; x < 8; ++x) row[x] += along * wx.difference[x] + across * wx.value[x];
      }
  }
};

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
  Splat splat{points, kernel, 1.0f / cell, {}, {}};
  std::array<int, 3> reach;  // voxels
  for (std::size_t i = 0; i < 3; ++i) {
    splat.side[i] = scale[i] * cell;
    const float width = std::max(std::max(kernel.thick, kernel.thin) / splat.side[i], 1.0f);
    reach[i] = static_cast<int>(std::ceil((1.5f * width + 0.5f) * cell)) + 1;
  }
  for_each(level.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickCoord coord = level.bricks.coords[brick];
    const int brick_at[3] = {coord.x, coord.y, coord.z};
    Splat own = splat;
    VoxelRange box[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const VoxelRange voxels = brick_voxels(level.exponent, brick_at[i]);
      const int low = ((voxels.first >> 3) - 1) * 8, high = low + 8 * index.side;
      box[i] = {std::max(voxels.first - reach[i], low), std::min(voxels.last + reach[i], high)};
      own.corner[i] = static_cast<float>(voxels.first);
    }
    float sum[kBrickCells] = {};
    visit_points(index, level.exponent, brick, coord, box,
                 [&](std::uint32_t from, std::uint32_t to) {
                   for (std::uint32_t p = from; p < to; ++p) own.add(p, sum);
                 });
    std::copy_n(sum, kBrickCells, right_hand_side.data() + kBrickCells * brick);
  });
}

void TbbBackend::poisson_restrict(const LevelView& coarse, View<const std::int32_t> children,
                                  View<const float> fine_values, View<float> coarse_values) {
  for_each(coarse.bricks.count, kGrain, [=](std::size_t brick) {
    const std::int32_t* fine = children.data() + 64 * brick;
    // The 18^3 fine cells round the brick, then restricted an axis at a time.
    float f[18][18][18], fx[18][18][8], fy[18][8][8];
    for (int z = 0; z < 18; ++z)
      for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 18; ++x) {
          const int gx = x + 7, gy = y + 7, gz = z + 7;  // from the corner of brick 2 B - 1
          const std::int32_t from = fine[(gx >> 3) + 4 * ((gy >> 3) + 4 * (gz >> 3))];
          f[z][y][x] = from == kNoBrick ? 0.0f
                                        : fine_values[std::size_t{kBrickCells} * from +
                                                      brick_cell(gx & 7, gy & 7, gz & 7)];
        }
    const auto restrict_four = [](float a, float b, float c, float d) {
      return 0.25f * (a + d) + 0.75f * (b + c);
    };
    for (int z = 0; z < 18; ++z)
      for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 8; ++x) {
          const float* row = f[z][y] + 2 * x;
          fx[z][y][x] = restrict_four(row[0], row[1], row[2], row[3]);
        }
    for (int z = 0; z < 18; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          fy[z][y][x] = restrict_four(fx[z][2 * y][x], fx[z][2 * y + 1][x], fx[z][2 * y + 2][x],
                                      fx[z][2 * y + 3][x]);
    float* out = coarse_values.data() + kBrickCells * brick;
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          out[brick_cell(x, y, z)] = restrict_four(fy[2 * z][y][x], fy[2 * z + 1][y][x],
                                                   fy[2 * z + 2][y][x], fy[2 * z + 3][y][x]);
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

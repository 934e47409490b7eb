/// Octree levels: unknown cells, splatting and divergence (eq. 3 and 4 of the paper), restriction
/// and prolongation of quadratic B-splines.

#include <array>
#include <cmath>

#include "tbb/point_gather.h"
#include "tbb/rows.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 4;  // bricks a task takes

/// Three values, one an axis; the fourth is none.
using Triple = float __attribute__((vector_size(16)));

/// Quadratic B-spline of unit knots, centred; its integral is one.
Row bspline(const Row& t) {
  const Row size = RowLanes::absolute(t), rest = 1.5f - size;
  const Row tail = rest < 0.0f ? Row{} : rest;
  const Row inner = 0.75f - t * t, outer = 0.5f * (tail * tail);
  return size < 0.5f ? inner : outer;
}

/// The B-spline of knots 1 / `inverse` cells at the 8 cells of a brick along one axis, and its
/// difference over each cell; `p` is the point's position from the brick's corner, in cells.
struct AxisWeights {
  AxisWeights(float p, float reach, float inverse) {
    constexpr Row kCell = {0, 1, 2, 3, 4, 5, 6, 7};
    first = std::max(0, static_cast<int>(std::ceil(p - reach - 0.5f)));
    last = std::min(8, static_cast<int>(std::floor(p + reach - 0.5f)) + 1);
    const Row below = bspline((kCell - p) * inverse), above = bspline((kCell + 1.0f - p) * inverse);
    value = bspline((kCell + 0.5f - p) * inverse) * inverse;
    difference = (above - below) * inverse;
  }
  Row value, difference;
  int first, last;
};

/// Adding points to the right-hand side of one brick.
struct Splat {
  PointView points;
  Kernel kernel;
  float per_voxel;  ///< cells a voxel
  Triple side;      ///< of a cell, voxel lengths
  Triple corner;    ///< of the brick, voxels

  static Triple load(const std::array<View<const float>, 3>& values, std::uint32_t p) {
    return Triple{values[0][p], values[1][p], values[2][p]};
  }

  void add(std::uint32_t p, float* sum) const {
    const Triple at = (load(points.position, p) - corner) * per_voxel;
    Triple width = kernel.at(points.thickness[p]) / side;
    width = width < 1.0f ? Triple{1, 1, 1, 1} : width;
    const Triple reach = 1.5f * width + 0.5f;
    const auto inside = (at > 0.5f - reach) & (at < 7.5f + reach);
    if ((inside[0] & inside[1] & inside[2]) == 0) return;
    const Triple inverse = 1.0f / width;
    const Triple n = load(points.normal, p), area = load(points.area, p);
    const float weight = (area[0] * n[0] + area[1] * n[1]) + area[2] * n[2];
    add_rows(weight * n / side, AxisWeights(at[0], reach[0], inverse[0]),
             AxisWeights(at[1], reach[1], inverse[1]), AxisWeights(at[2], reach[2], inverse[2]),
             sum);
  }

  static void add_rows(const Triple& a, const AxisWeights& x, const AxisWeights& y,
                       const AxisWeights& z, float* sum) {
    for (int k = z.first; k < z.last; ++k) {
      // along[j], across[j]: what the row at (j, k) takes of x's differences and values
      const Row along = a[0] * (y.value * z.value[k]);
      const Row across = a[1] * (y.difference * z.value[k]) + a[2] * (y.value * z.difference[k]);
      for (int j = y.first; j < y.last; ++j) {
        float* row = sum + brick_cell(0, j, k);
        store_row(row, load_row(row) + (along[j] * x.difference + across[j] * x.value));
      }
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
  Splat splat{points, kernel, 1.0f / cell, {1, 1, 1, 1}, {}};
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
    float* sum = right_hand_side.data() + kBrickCells * brick;
    std::fill_n(sum, kBrickCells, 0.0f);
    visit_points(index, level.exponent, brick, coord, box,
                 [&](std::uint32_t from, std::uint32_t to) {
                   for (std::uint32_t p = from; p < to; ++p) own.add(p, sum);
                 });
  });
}

void TbbBackend::poisson_restrict(const LevelView& coarse, View<const std::int32_t> children,
                                  View<const float> fine_values, View<float> coarse_values) {
  const auto restrict_four = [](const Row& a, const Row& b, const Row& c, const Row& d) {
    return 0.25f * (a + d) + 0.75f * (b + c);
  };
  for_each(coarse.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickTable fine(children.data() + 64 * brick, 4, fine_values.data());
    // The 18^3 fine cells round the brick, restricted an axis at a time.
    Row along_x[18][18], along_y[18][8];
    for (int z = 0; z < 18; ++z)
      for (int y = 0; y < 18; ++y) {
        const Row u = fine.row(1, y + 7, z + 7), v = fine.row(2, y + 7, z + 7);
        const Row even = __builtin_shufflevector(u, v, 0, 2, 4, 6, 8, 10, 12, 14);
        const Row odd = __builtin_shufflevector(u, v, 1, 3, 5, 7, 9, 11, 13, 15);
        along_x[z][y] = restrict_four(shifted_up(odd, fine.cell(7, y + 7, z + 7)), even, odd,
                                      shifted_down(even, fine.cell(24, y + 7, z + 7)));
      }
    for (int z = 0; z < 18; ++z)
      for (int y = 0; y < 8; ++y) {
        const Row* from = along_x[z] + 2 * y;
        along_y[z][y] = restrict_four(from[0], from[1], from[2], from[3]);
      }
    float* out = coarse_values.data() + kBrickCells * brick;
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        store_row(out + brick_cell(0, y, z),
                  restrict_four(along_y[2 * z][y], along_y[2 * z + 1][y], along_y[2 * z + 2][y],
                                along_y[2 * z + 3][y]));
  });
}

void TbbBackend::poisson_prolong(const LevelView& fine, View<const std::int32_t> parents,
                                 View<const float> coarse_values, View<float> fine_values) {
  // Fine cell 2 i: 3/4 of coarse i and 1/4 of i - 1; fine cell 2 i + 1: 3/4 of i, 1/4 of i + 1.
  const auto refine = [](const Row& own, const Row& other) { return 0.75f * own + 0.25f * other; };
  for_each(fine.bricks.count, kGrain, [=](std::size_t brick) {
    const BrickTable coarse(parents.data() + 27 * brick, 3, coarse_values.data());
    const BrickCoord coord = fine.bricks.coords[brick];
    const int y0 = (coord.y & 1) * 4 + 7, z0 = (coord.z & 1) * 4 + 7;
    // The 6^3 coarse cells over the brick, refined an axis at a time.
    Row along_x[6][6], along_y[6][8];
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 6; ++y) {
        const Row half = coarse.row(1, y0 + y, z0 + z);
        const Row six = coord.x & 1
                            ? __builtin_shufflevector(half, Row{coarse.cell(16, y0 + y, z0 + z)}, 3,
                                                      4, 5, 6, 7, 8, 9, 9)
                            : shifted_up(half, coarse.cell(7, y0 + y, z0 + z));
        along_x[z][y] = refine(__builtin_shufflevector(six, six, 1, 1, 2, 2, 3, 3, 4, 4),
                               __builtin_shufflevector(six, six, 0, 2, 1, 3, 2, 4, 3, 5));
      }
    for (int z = 0; z < 6; ++z)
      for (int y = 0; y < 8; ++y) {
        const int own = (y >> 1) + 1, other = y & 1 ? own + 1 : own - 1;
        along_y[z][y] = refine(along_x[z][own], along_x[z][other]);
      }
    float* out = fine_values.data() + kBrickCells * brick;
    for (int z = 0; z < 8; ++z) {
      const int own = (z >> 1) + 1, other = z & 1 ? own + 1 : own - 1;
      for (int y = 0; y < 8; ++y)
        store_row(out + brick_cell(0, y, z), refine(along_y[own][y], along_y[other][y]));
    }
  });
}

}  // namespace vasamesh

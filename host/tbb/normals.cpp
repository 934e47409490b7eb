/// Normal vectors: the occupancy gradient, and the covariance of neighbours of the same sheet.

#include "stages/normals.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "backend/ranges.h"
#include "stages/gradient_table.h"
#include "stages/jacobi.h"
#include "tbb/nearest.h"
#include "tbb/tbb_backend.h"
#include "types/row_bits.h"

namespace vasamesh {

namespace {

template <class Views>
Vec load(const Views& views, std::size_t i) {
  return {views[0][i], views[1][i], views[2][i]};
}

Vec divided(const Vec& v, float by) { return {v[0] / by, v[1] / by, v[2] / by}; }

void store(const std::array<View<float>, 3>& views, std::size_t i, const Vec& v) {
  for (int axis = 0; axis < 3; ++axis) views[axis][i] = v[axis];
}

// --- Gradient. ---------------------------------------------------------------------------------

constexpr std::size_t kPointGrain = 512;  // points a task takes
constexpr std::size_t kBrickGrain = 8;    // bricks a task takes

/// Sum of weight * offset over the object voxels in reach of a point: towards the object.
Vec occupancy_gradient(const BitView& object, const GradientTable& table, const Vec& position) {
  const LatticePlace x = lattice_place(position[0]), y = lattice_place(position[1]),
                     z = lattice_place(position[2]);
  const GradientSum *wy = table.voxels(1, y.fraction), *wz = table.voxels(2, z.fraction);
  const GradientSum* pattern = table.rows(x.fraction);
  const int first = x.base - table.reach[0], span = 2 * table.reach[0] + 1;
  Vec sum{0, 0, 0};
  for (int k = 0; k <= 2 * table.reach[2]; ++k) {
    Vec slice{0, 0, 0};  // moment along x, moment along y, weight
    for (int j = 0; j <= 2 * table.reach[1]; ++j) {
      const std::size_t row = object.row(y.base - table.reach[1] + j, z.base - table.reach[2] + k);
      const unsigned bits = row_bits(object.words.data() + row, first, span);
      if (bits == 0) continue;
      const GradientSum low = pattern[bits & 0xffu], high = pattern[256 + (bits >> 8)];
      const float weight = low.weight + high.weight, moment = low.moment + high.moment;
      slice[0] += wy[j].weight * moment;
      slice[1] += wy[j].moment * weight;
      slice[2] += wy[j].weight * weight;
    }
    sum[0] += wz[k].weight * slice[0];
    sum[1] += wz[k].weight * slice[1];
    sum[2] += wz[k].moment * slice[2];
  }
  return sum;
}

/// True when a unit vector points against the faces behind its point.
bool is_against(const Vec& outward, const Vec& area) {
  const float along = dot(outward, area);
  return along < 0.0f && along * along > kAgainstFaces * dot(area, area);
}

/// Unit vector out of the object; \see Backend::normals_gradient.
Vec outward_gradient(const BitView& object, const GradientTable& wide, const GradientTable& narrow,
                     const Vec& position, const Vec& area) {
  for (const GradientTable* table : {&wide, &narrow}) {
    const Vec inward = occupancy_gradient(object, *table, position);
    const float square = dot(inward, inward);
    if (square < kNoGradient) continue;
    const Vec outward = divided(inward, -std::sqrt(square));
    if (!is_against(outward, area)) return outward;
  }
  return divided(area, std::sqrt(dot(area, area)));
}

// --- Covariance. -------------------------------------------------------------------------------

/// The neighbours of eight points side by side; zeros where a point has fewer than another.
struct NeighbourRows {
  NeighbourRows(const NearestRows& nearest, int lanes) {
    float number[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    for (int lane = 0; lane < lanes; ++lane) {
      number[lane] = static_cast<float>(nearest.count(lane));
      most = std::max(most, nearest.count(lane));
    }
    count = load_row(number);
    for (int i = 0; i < most; ++i) {
      float values[3][8] = {};
      for (int lane = 0; lane < lanes; ++lane)
        for (int axis = 0; axis < 3 && i < nearest.count(lane); ++axis)
          values[axis][lane] = nearest.offset(lane, i)[axis];
      offset[i] = {load_row(values[0]), load_row(values[1]), load_row(values[2])};
    }
  }
  int most = 0;
  Row count;
  std::array<VecRows, NearestRows::kMost> offset;
};

/// The matrices k C = sum of (p_i - mean) (p_i - mean)^T + k tau (1 - g g^T).
void covariances(const NeighbourRows& neighbours, const VecRows& g, Row (&c)[3][3]) {
  VecRows mean{};
  for (int i = 0; i < neighbours.most; ++i)
    for (int axis = 0; axis < 3; ++axis) mean[axis] += neighbours.offset[i][axis];
  for (Row& axis : mean) axis = axis / neighbours.count;
  const Row weight = kTangentWeight * neighbours.count;
  for (int j = 0; j < 3; ++j)
    for (int k = j; k < 3; ++k)
      c[j][k] = j == k ? weight * (1.0f - g[j] * g[k]) : -weight * (g[j] * g[k]);
  for (int i = 0; i < neighbours.most; ++i) {
    const RowMask there = neighbours.count > static_cast<float>(i);
    VecRows d;
    for (int axis = 0; axis < 3; ++axis)
      d[axis] = where(there, neighbours.offset[i][axis] - mean[axis]);
    for (int j = 0; j < 3; ++j)
      for (int k = j; k < 3; ++k) c[j][k] += d[j] * d[k];
  }
  c[1][0] = c[0][1], c[2][0] = c[0][2], c[2][1] = c[1][2];
}

/// The normals of the planes through the neighbours; gradients where those are against the faces.
VecRows plane_normals(const NeighbourRows& neighbours, const VecRows& gradient,
                      const VecRows& area) {
  Row matrix[3][3];
  covariances(neighbours, gradient, matrix);
  const VecRows v = least_eigenvector<RowLanes>(matrix);
  const Row length = RowLanes::square_root(dot(v, v));
  const Row by = dot(v, gradient) < 0.0f ? -length : length;
  VecRows normal = {v[0] / by, v[1] / by, v[2] / by};
  const Row along = dot(normal, area);
  const RowMask against = (along < 0.0f) & (along * along > kAgainstFaces * dot(area, area));
  for (int axis = 0; axis < 3; ++axis) normal[axis] = against ? gradient[axis] : normal[axis];
  return normal;
}

/// Three values of the points from `first` on, as many as `count`; then the last of them again.
template <class Views>
VecRows load_rows(const Views& views, std::uint32_t first, int count) {
  VecRows rows;
  for (int axis = 0; axis < 3; ++axis)
    for (int lane = 0; lane < 8; ++lane)
      rows[axis][lane] = views[axis][first + static_cast<std::uint32_t>(std::min(lane, count - 1))];
  return rows;
}

/// What one task of the covariance pass holds.
struct Workspace {
  explicit Workspace(int neighbours) : nearest(neighbours) {}

  Neighbourhood near;
  std::vector<Neighbourhood::Candidate> candidates;
  NearestRows nearest;
};

}  // namespace

void TbbBackend::normals_gradient(const BitView& object, const PointView& points,
                                  const Scale& scale, float sigma,
                                  std::array<View<float>, 3> normals) {
  const GradientTable wide = make_gradient_table(scale, sigma);
  const GradientTable narrow = make_gradient_table(scale, 0.5f * sigma);
  for_each(points.count, kPointGrain, [&](std::size_t i) {
    const Vec position = load(points.position, i), area = load(points.area, i);
    store(normals, i, outward_gradient(object, wide, narrow, position, area));
  });
}

void TbbBackend::normals_covariance(const PointView& points, const BrickView& bricks,
                                    View<const std::uint32_t> voxel_start, const Scale& scale,
                                    int k, std::array<View<const float>, 3> gradients,
                                    std::array<View<float>, 3> normals) {
  const auto estimate_brick = [&](std::size_t brick, Workspace& work) {
    work.near.gather(points, bricks, voxel_start, gradients, brick);
    const BrickCoord at = bricks.coords[brick];
    for (int voxel = 0; voxel < kBrickCells; ++voxel) {
      const std::uint32_t first = voxel_start[brick * kBrickCells + voxel],
                          last = voxel_start[brick * kBrickCells + voxel + 1];
      if (first == last) continue;
      const int x = voxel & 7, y = voxel >> 3 & 7, z = voxel >> 6;
      work.near.collect(x, y, z, work.candidates);
      for (std::uint32_t i = first; i < last; i += 8) {
        const int count = static_cast<int>(std::min(last - i, 8u));
        const Queries queries{count,
                              load_rows(points.position, i, count),
                              load_rows(gradients, i, count),
                              {8 * at.x + x, 8 * at.y + y, 8 * at.z + z}};
        work.nearest.find(work.candidates, queries, scale);
        const VecRows found = plane_normals(NeighbourRows(work.nearest, count), queries.gradient,
                                            load_rows(points.area, i, count));
        for (int lane = 0; lane < count; ++lane)
          store(normals, i + lane, {found[0][lane], found[1][lane], found[2][lane]});
      }
    }
  };
  for_each_range(*this, bricks.count, kBrickGrain, [&](std::size_t begin, std::size_t end) {
    const auto work = std::make_unique<Workspace>(k + 1);
    for (std::size_t brick = begin; brick < end; ++brick) estimate_brick(brick, *work);
  });
}

}  // namespace vasamesh

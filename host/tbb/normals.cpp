/// Normal vectors: the occupancy gradient, and the covariance of neighbours of the same sheet.

#include "stages/normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stages/gradient_table.h"
#include "stages/jacobi.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

using Vec = std::array<float, 3>;

float dot(const Vec& a, const Vec& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

template <class Views>
Vec load(const Views& views, std::size_t i) {
  return {views[0][i], views[1][i], views[2][i]};
}

Vec divided(const Vec& v, float by) { return {v[0] / by, v[1] / by, v[2] / by}; }

void store(const std::array<View<float>, 3>& views, std::size_t i, const Vec& v) {
  for (int axis = 0; axis < 3; ++axis) views[axis][i] = v[axis];
}

// --- Gradient. ---------------------------------------------------------------------------------

constexpr std::size_t kPointGrain = 512;

/// Bits first .. first + span - 1 of a row; in the row or its padding. \pre span <= 16.
unsigned row_bits(const std::uint64_t* row, int first, int span) {
  const int word = first >> 6, shift = first & 63;
  std::uint64_t bits = row[word] >> shift;
  if (shift + span > 64) bits |= row[word + 1] << (64 - shift);
  return static_cast<unsigned>(bits & ((1u << span) - 1));
}

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

// --- Covariance. -------------------------------------------------------------------------------

constexpr int kReach = kNeighbourReach;
constexpr int kSpan = kBrickSide + 2 * kReach;
constexpr int kMaxNeighbours = 64;

/// The points of a brick and of the voxels round it, copied together, row after row of voxels.
class Neighbourhood {
 public:
  std::vector<float> position[3], gradient[3];
  std::vector<std::uint32_t> index;

  void gather(const PointView& points, const BrickView& bricks,
              View<const std::uint32_t> voxel_start, std::array<View<const float>, 3> gradients,
              std::size_t brick) {
    index.clear();
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    std::size_t cell = 0;
    for (int z = -kReach; z < kBrickSide + kReach; ++z)
      for (int y = -kReach; y < kBrickSide + kReach; ++y)
        for (int x = -kReach; x < kBrickSide + kReach; ++x)
          append(near, voxel_start, x, y, z, cell++);
    start_[cell] = static_cast<std::uint32_t>(index.size());
    for (int axis = 0; axis < 3; ++axis) {
      position[axis].resize(index.size());
      gradient[axis].resize(index.size());
      for (std::size_t i = 0; i < index.size(); ++i) {
        position[axis][i] = points.position[axis][index[i]];
        gradient[axis][i] = gradients[axis][index[i]];
      }
    }
  }

  /// The points of voxels (x0 .. x1, y, z), as a range of the arrays; brick coordinates.
  std::uint32_t begin(int x0, int y, int z) const { return start_[cell_of(x0, y, z)]; }
  std::uint32_t end(int x1, int y, int z) const { return start_[cell_of(x1, y, z) + 1]; }

 private:
  static std::size_t cell_of(int x, int y, int z) {
    return static_cast<std::size_t>(x + kReach + kSpan * (y + kReach + kSpan * (z + kReach)));
  }

  void append(const std::int32_t* near, View<const std::uint32_t> voxel_start, int x, int y, int z,
              std::size_t cell) {
    start_[cell] = static_cast<std::uint32_t>(index.size());
    const std::int32_t b = near[brick_neighbour(x >> 3, y >> 3, z >> 3)];
    if (b == kNoBrick) return;
    const std::size_t voxel = std::size_t{kBrickCells} * b + brick_cell(x & 7, y & 7, z & 7);
    for (std::uint32_t i = voxel_start[voxel]; i < voxel_start[voxel + 1]; ++i) index.push_back(i);
  }

  std::uint32_t start_[kSpan * kSpan * kSpan + 1];
};

/// The nearest points so far, by distance, then index.
class NearestList {
 public:
  explicit NearestList(int capacity) : capacity_(capacity) {}

  void clear() { count_ = 0; }
  int count() const { return count_; }
  bool full() const { return count_ == capacity_; }
  float farthest() const { return entries_[count_ - 1].distance; }
  std::uint32_t place(int i) const { return entries_[i].place; }

  void offer(float distance, std::uint32_t index, std::uint32_t place) {
    const auto before = [&](const Entry& e) {
      return distance < e.distance || (distance == e.distance && index < e.index);
    };
    if (full() && !before(entries_[count_ - 1])) return;
    int i = full() ? count_ - 1 : count_++;
    for (; i > 0 && before(entries_[i - 1]); --i) entries_[i] = entries_[i - 1];
    entries_[i] = {distance, index, place};
  }

 private:
  struct Entry {
    float distance;
    std::uint32_t index, place;
  };
  int capacity_, count_ = 0;
  Entry entries_[kMaxNeighbours];
};

/// One point whose neighbours are sought; voxel in brick coordinates.
struct Query {
  Vec position, gradient;
  std::array<int, 3> voxel;
  std::array<int, 3> brick_corner;
};

/// The square of the distance within which a search of `reach` voxels sees every point.
float covered(const Query& query, const Scale& scale, int reach) {
  float least = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int voxel = query.brick_corner[axis] + query.voxel[axis];
    const float below = query.position[axis] - static_cast<float>(voxel - reach);
    const float above = static_cast<float>(voxel + reach + 1) - query.position[axis];
    const float axis_least = std::min(below, above) * scale[axis];
    least = axis == 0 ? axis_least : std::min(least, axis_least);
  }
  return least * least;
}

void search(const Neighbourhood& near, const Query& query, const Scale& scale, int reach,
            NearestList& nearest) {
  const auto [x, y, z] = query.voxel;
  for (int dz = -reach; dz <= reach; ++dz)
    for (int dy = -reach; dy <= reach; ++dy) {
      const std::uint32_t end = near.end(x + reach, y + dy, z + dz);
      for (std::uint32_t i = near.begin(x - reach, y + dy, z + dz); i < end; ++i) {
        Vec offset, gradient;
        for (int axis = 0; axis < 3; ++axis) {
          offset[axis] = (near.position[axis][i] - query.position[axis]) * scale[axis];
          gradient[axis] = near.gradient[axis][i];
        }
        if (dot(gradient, query.gradient) > kSameSheet)
          nearest.offer(dot(offset, offset), near.index[i], i);
      }
    }
}

void find_neighbours(const Neighbourhood& near, const Query& query, const Scale& scale,
                     NearestList& nearest) {
  for (int reach = 1; reach <= kReach; ++reach) {
    nearest.clear();
    search(near, query, scale, reach, nearest);
    if (nearest.full() && nearest.farthest() < covered(query, scale, reach)) return;
  }
}

/// The plane's normal through the neighbours, or the gradient where they tell no plane.
Vec plane_normal(const Neighbourhood& near, const Query& query, const Scale& scale,
                 const NearestList& nearest) {
  const int count = nearest.count();
  if (count < 3) return query.gradient;
  Vec offsets[kMaxNeighbours], mean{0, 0, 0};
  for (int i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      offsets[i][axis] =
          (near.position[axis][nearest.place(i)] - query.position[axis]) * scale[axis];
      mean[axis] += offsets[i][axis];
    }
  mean = divided(mean, static_cast<float>(count));
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (int i = 0; i < count; ++i) {
    const float x = offsets[i][0] - mean[0], y = offsets[i][1] - mean[1],
                z = offsets[i][2] - mean[2];
    xx += x * x, xy += x * y, xz += x * z, yy += y * y, yz += y * z, zz += z * z;
  }
  const Eigen3 eigen = eigen_symmetric(xx, xy, xz, yy, yz, zz);
  if (!(eigen.value[0] < kPlaneRatio * eigen.value[1])) return query.gradient;
  const Vec& v = eigen.vector[0];
  const float length = std::sqrt(dot(v, v));
  return divided(v, dot(v, query.gradient) < 0.0f ? -length : length);
}

}  // namespace

void TbbBackend::normals_gradient(const BitView& object, const PointView& points,
                                  const Scale& scale, float sigma,
                                  std::array<View<float>, 3> normals) {
  const GradientTable table = make_gradient_table(scale, sigma);
  for_each(points.count, kPointGrain, [&](std::size_t i) {
    const Vec inward = occupancy_gradient(object, table, load(points.position, i));
    Vec outward{-inward[0], -inward[1], -inward[2]};
    float square = dot(outward, outward);
    if (square < 1e-12f) {
      outward = load(points.area, i);
      square = dot(outward, outward);
    }
    store(normals, i, divided(outward, std::sqrt(square)));
  });
}

void TbbBackend::normals_covariance(const PointView& points, const BrickView& bricks,
                                    View<const std::uint32_t> voxel_start, const Scale& scale,
                                    int k, std::array<View<const float>, 3> gradients,
                                    std::array<View<float>, 3> normals) {
  constexpr std::size_t kBricksATask = 8;
  for_each((bricks.count + kBricksATask - 1) / kBricksATask, 1, [&](std::size_t task) {
    Neighbourhood near;
    NearestList nearest(k);
    const std::size_t end = std::min((task + 1) * kBricksATask, bricks.count);
    for (std::size_t brick = task * kBricksATask; brick < end; ++brick) {
      near.gather(points, bricks, voxel_start, gradients, brick);
      const BrickCoord at = bricks.coords[brick];
      for (int voxel = 0; voxel < kBrickCells; ++voxel) {
        const std::size_t v = brick * kBrickCells + voxel;
        for (std::uint32_t i = voxel_start[v]; i < voxel_start[v + 1]; ++i) {
          const Query query{load(points.position, i),
                            load(gradients, i),
                            {voxel & 7, voxel >> 3 & 7, voxel >> 6},
                            {8 * at.x, 8 * at.y, 8 * at.z}};
          find_neighbours(near, query, scale, nearest);
          store(normals, i, plane_normal(near, query, scale, nearest));
        }
      }
    }
  });
}

}  // namespace vasamesh

/// Normal vectors: the occupancy gradient, and the covariance of neighbours of the same sheet.

#include "stages/normals.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
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

constexpr std::size_t kPointGrain = 512;  // points a task takes
constexpr std::size_t kBrickGrain = 8;    // bricks a task takes

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

constexpr int kReach = kNeighbourReach;
constexpr int kBlock = 2 * kReach + 1;
constexpr int kSpan = kBrickSide + 2 * kReach;
constexpr int kMaxNeighbours = 64 + 1;  // with the point's own voxel

/// The points of a brick and of the voxels round it, copied together, row after row of voxels.
class Neighbourhood {
 public:
  struct Sample {
    Vec position, gradient;
    std::uint32_t index;  // in the point cloud
  };

  void gather(const PointView& points, const BrickView& bricks,
              View<const std::uint32_t> voxel_start,
              const std::array<View<const float>, 3>& gradients, std::size_t brick) {
    samples_.clear();
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    std::uint32_t cell = 0;
    for (int z = -kReach; z < kBrickSide + kReach; ++z)
      for (int y = -kReach; y < kBrickSide + kReach; ++y)
        for (int x = -kReach; x < kBrickSide + kReach; ++x, ++cell) {
          start_[cell] = static_cast<std::uint32_t>(samples_.size());
          const std::int32_t b = near[brick_neighbour(x >> 3, y >> 3, z >> 3)];
          if (b == kNoBrick) continue;
          const std::size_t voxel = std::size_t{kBrickCells} * b + brick_cell(x & 7, y & 7, z & 7);
          for (std::uint32_t i = voxel_start[voxel]; i < voxel_start[voxel + 1]; ++i)
            samples_.push_back({load(points.position, i), load(gradients, i), i});
        }
    start_[cell] = static_cast<std::uint32_t>(samples_.size());
  }

  /// The samples of a voxel; brick coordinates.
  std::span<const Sample> voxel(int x, int y, int z) const {
    const int cell = cell_of(x, y, z);
    return {samples_.data() + start_[cell], start_[cell + 1] - start_[cell]};
  }
  /// True where no voxel in reach of x has samples in the row.
  bool row_is_empty(int x, int y, int z) const {
    return start_[cell_of(x - kReach, y, z)] == start_[cell_of(x + kReach, y, z) + 1];
  }

 private:
  static int cell_of(int x, int y, int z) {
    return x + kReach + kSpan * (y + kReach + kSpan * (z + kReach));
  }

  std::vector<Sample> samples_;
  std::uint32_t start_[kSpan * kSpan * kSpan + 1];
};

/// A neighbour: the samples of one voxel that agree with the point, at their mean.
struct Neighbour {
  float distance;       // squared
  std::uint32_t index;  // of its first sample: breaks ties
  Vec offset;           // from the point, in voxel lengths

  bool before(const Neighbour& other) const {
    return distance < other.distance || (distance == other.distance && index < other.index);
  }
};

/// The nearest neighbours so far, in order.
class NearestList {
 public:
  explicit NearestList(int capacity) : capacity_(capacity) {}

  void clear() { count_ = 0; }
  bool full() const { return count_ == capacity_; }
  /// True when nothing at this squared distance or beyond can be among the nearest.
  bool excludes(float distance) const {
    return full() && distance > kSafe * entries_[count_ - 1].distance;
  }
  std::span<const Neighbour> entries() const {
    return {entries_, static_cast<std::size_t>(count_)};
  }

  void offer(const Neighbour& candidate) {
    if (full() && !candidate.before(entries_[count_ - 1])) return;
    int i = full() ? count_ - 1 : count_++;
    for (; i > 0 && candidate.before(entries_[i - 1]); --i) entries_[i] = entries_[i - 1];
    entries_[i] = candidate;
  }

 private:
  static constexpr float kSafe = 1.001f;  // covers the rounding of distances

  int capacity_, count_ = 0;
  Neighbour entries_[kMaxNeighbours];
};

/// One point whose neighbours are sought.
struct Query {
  Vec position, gradient;
  std::array<int, 3> voxel;
};

/// The rows of voxels in reach, (dy, dz), nearest first.
struct RowOffsets {
  std::array<std::array<int, 2>, kBlock * kBlock> offset;

  RowOffsets() {
    for (int i = 0; i < kBlock * kBlock; ++i)
      offset[i] = {i % kBlock - kReach, i / kBlock - kReach};
    const auto square = [](const std::array<int, 2>& o) { return o[0] * o[0] + o[1] * o[1]; };
    std::stable_sort(offset.begin(), offset.end(),
                     [&](const auto& a, const auto& b) { return square(a) < square(b); });
  }
};

/// Squares of the distances from a point to the slabs of voxels round its own, along each axis.
struct Gaps {
  std::array<std::array<float, kBlock>, 3> square;

  Gaps(const Query& query, const Scale& scale) {
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < kBlock; ++i) {
        const int voxel = query.voxel[axis] + i - kReach;
        const float below = static_cast<float>(voxel) - query.position[axis];
        const float above = query.position[axis] - static_cast<float>(voxel + 1);
        const float gap = std::max(std::max(below, above), 0.0f) * scale[axis];
        square[axis][i] = gap * gap;
      }
  }
};

/// The neighbour that one voxel's samples make; false where none of them agrees.
bool make_neighbour(std::span<const Neighbourhood::Sample> samples, const Query& query,
                    const Scale& scale, Neighbour& neighbour) {
  Vec sum{0, 0, 0};
  float agreeing = 0;
  for (const Neighbourhood::Sample& sample : samples) {
    // a factor in place of a branch, which both sheets of a thin vessel make unpredictable
    const float agrees = dot(sample.gradient, query.gradient) > kSameSheet ? 1.0f : 0.0f;
    for (int axis = 0; axis < 3; ++axis)
      sum[axis] += agrees * (sample.position[axis] - query.position[axis]);
    agreeing += agrees;
  }
  if (agreeing == 0) return false;
  for (int axis = 0; axis < 3; ++axis)
    neighbour.offset[axis] = (sum[axis] / agreeing) * scale[axis];
  neighbour.distance = dot(neighbour.offset, neighbour.offset);
  neighbour.index = samples.front().index;
  return true;
}

/// A voxel with samples in reach of another, and where it lies in the block round that one.
struct Candidate {
  std::span<const Neighbourhood::Sample> samples;
  std::array<int, 3> place;
};

/// The voxels in reach of voxel (x, y, z) that have samples, the nearest rows first.
void collect_candidates(const Neighbourhood& near, int x, int y, int z,
                        std::vector<Candidate>& candidates) {
  static const RowOffsets rows;
  candidates.clear();
  for (const auto [dy, dz] : rows.offset) {
    if (near.row_is_empty(x, y + dy, z + dz)) continue;
    for (int dx = -kReach; dx <= kReach; ++dx)
      if (const auto samples = near.voxel(x + dx, y + dy, z + dz); !samples.empty())
        candidates.push_back({samples, {dx + kReach, dy + kReach, dz + kReach}});
  }
}

/// The nearest neighbours; skips voxels that are farther than those at hand.
void find_neighbours(std::span<const Candidate> candidates, const Query& query, const Scale& scale,
                     NearestList& nearest) {
  const Gaps gaps(query, scale);
  Neighbour neighbour;
  nearest.clear();
  for (const Candidate& candidate : candidates) {
    const auto [x, y, z] = candidate.place;
    if (nearest.excludes(gaps.square[0][x] + gaps.square[1][y] + gaps.square[2][z])) continue;
    if (make_neighbour(candidate.samples, query, scale, neighbour)) nearest.offer(neighbour);
  }
}

/// Six entries of a symmetric 3 x 3 matrix.
struct Symmetric {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add_square(const Vec& v) {
    xx += v[0] * v[0];
    xy += v[0] * v[1];
    xz += v[0] * v[2];
    yy += v[1] * v[1];
    yz += v[1] * v[2];
    zz += v[2] * v[2];
  }
};

/// The tangent plane of the gradient g as a matrix: weight * (1 - g g^T).
Symmetric tangent_plane(const Vec& g, float weight) {
  return {weight * (1.0f - g[0] * g[0]), -weight * (g[0] * g[1]), -weight * (g[0] * g[2]),
          weight * (1.0f - g[1] * g[1]), -weight * (g[1] * g[2]), weight * (1.0f - g[2] * g[2])};
}

/// The normal of the plane through the neighbours; the gradient where that is against the faces.
Vec plane_normal(std::span<const Neighbour> neighbours, const Vec& gradient, const Vec& area) {
  const auto count = static_cast<float>(neighbours.size());
  Vec mean{0, 0, 0};
  for (const Neighbour& n : neighbours)
    for (int axis = 0; axis < 3; ++axis) mean[axis] += n.offset[axis];
  mean = divided(mean, count);
  // k C = sum of (p_i - mean) (p_i - mean)^T + k tau (1 - g g^T)
  Symmetric c = tangent_plane(gradient, kTangentWeight * count);
  for (const Neighbour& n : neighbours)
    c.add_square({n.offset[0] - mean[0], n.offset[1] - mean[1], n.offset[2] - mean[2]});
  const Eigen3 eigen = eigen_symmetric(c.xx, c.xy, c.xz, c.yy, c.yz, c.zz);
  const Vec& v = eigen.vector[0];
  const float length = std::sqrt(dot(v, v));
  const Vec normal = divided(v, dot(v, gradient) < 0.0f ? -length : length);
  return is_against(normal, area) ? gradient : normal;
}

/// What one task of the covariance pass holds.
struct Workspace {
  explicit Workspace(int neighbours) : nearest(neighbours) {}

  Neighbourhood near;
  std::vector<Candidate> candidates;
  NearestList nearest;
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
      collect_candidates(work.near, x, y, z, work.candidates);
      for (std::uint32_t i = first; i < last; ++i) {
        const Query query{load(points.position, i),
                          load(gradients, i),
                          {8 * at.x + x, 8 * at.y + y, 8 * at.z + z}};
        find_neighbours(work.candidates, query, scale, work.nearest);
        store(normals, i,
              plane_normal(work.nearest.entries(), query.gradient, load(points.area, i)));
      }
    }
  };
  for_each((bricks.count + kBrickGrain - 1) / kBrickGrain, 1, [&](std::size_t task) {
    const auto work = std::make_unique<Workspace>(k + 1);
    const std::size_t end = std::min((task + 1) * kBrickGrain, bricks.count);
    for (std::size_t brick = task * kBrickGrain; brick < end; ++brick) estimate_brick(brick, *work);
  });
}

}  // namespace vasamesh

#pragma once

/// \file
/// The nearest neighbours of samples (engine/stages/normals.h), for up to eight points of a voxel
/// at once, a lane each: they look at the same voxels.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "stages/normals.h"
#include "tbb/rows.h"

namespace vasamesh {

using Vec = std::array<float, 3>;
using VecRows = std::array<Row, 3>;

template <class Number>
Number dot(const std::array<Number, 3>& a, const std::array<Number, 3>& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

/// The points of a brick and of the voxels round it, copied together, row after row of voxels.
class Neighbourhood {
 public:
  static constexpr int kReach = kNeighbourReach;
  static constexpr int kBlock = 2 * kReach + 1;

  struct Sample {
    Vec position, gradient;
    std::uint32_t index;  // in the point cloud
  };

  /// A voxel with samples in reach of another, and where it lies in the block round that one.
  struct Candidate {
    std::span<const Sample> samples;
    std::array<int, 3> place;
  };

  void gather(const PointView& points, const BrickView& bricks,
              View<const std::uint32_t> voxel_start,
              const std::array<View<const float>, 3>& gradients, std::size_t brick) {
    samples_.clear();
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    std::uint32_t cell = 0;
    for (int z = -kReach; z < kBrickSide + kReach; ++z)
      for (int y = -kReach; y < kBrickSide + kReach; ++y) {
        std::uint32_t& occupied = occupied_[row_of(y, z)];
        occupied = 0;
        for (int x = -kReach; x < kBrickSide + kReach; ++x, ++cell) {
          start_[cell] = static_cast<std::uint32_t>(samples_.size());
          const std::int32_t b = near[brick_neighbour(x >> 3, y >> 3, z >> 3)];
          if (b == kNoBrick) continue;
          const std::size_t voxel = std::size_t{kBrickCells} * b + brick_cell(x & 7, y & 7, z & 7);
          for (std::uint32_t i = voxel_start[voxel]; i < voxel_start[voxel + 1]; ++i)
            samples_.push_back({load(points.position, i), load(gradients, i), i});
          if (start_[cell] < samples_.size()) occupied |= 1u << (x + kReach);
        }
      }
    start_[cell] = static_cast<std::uint32_t>(samples_.size());
  }

  /// The voxels in reach of voxel (x, y, z) of the brick that have samples, nearest first.
  void collect(int x, int y, int z, std::vector<Candidate>& candidates) const {
    std::array<int, kFarthest + 2> start{};  // by the square of the distance, and the end
    const auto square = [](int dx, int dy, int dz) { return dx * dx + dy * dy + dz * dz; };
    visit_near(x, y, z, [&](int dx, int dy, int dz) { ++start[square(dx, dy, dz)]; });
    std::exclusive_scan(start.begin(), start.end(), start.begin(), 0);
    candidates.resize(static_cast<std::size_t>(start.back()));
    visit_near(x, y, z, [&](int dx, int dy, int dz) {
      const int cell = cell_of(x + dx, y + dy, z + dz);
      candidates[start[square(dx, dy, dz)]++] = {
          {samples_.data() + start_[cell], start_[cell + 1] - start_[cell]},
          {dx + kReach, dy + kReach, dz + kReach}};
    });
  }

 private:
  static constexpr int kSpan = kBrickSide + 2 * kReach;

  static constexpr int kFarthest = 3 * kReach * kReach;

  /// visit(dx, dy, dz) for the voxels in reach that have samples.
  template <class Visit>
  void visit_near(int x, int y, int z, const Visit& visit) const {
    for (int dz = -kReach; dz <= kReach; ++dz)
      for (int dy = -kReach; dy <= kReach; ++dy) {
        const unsigned row = occupied_[row_of(y + dy, z + dz)] >> x;
        for (unsigned bits = row & ((1u << kBlock) - 1); bits != 0; bits &= bits - 1)
          visit(std::countr_zero(bits) - kReach, dy, dz);
      }
  }

  template <class Views>
  static Vec load(const Views& views, std::size_t i) {
    return {views[0][i], views[1][i], views[2][i]};
  }
  static int row_of(int y, int z) { return y + kReach + kSpan * (z + kReach); }
  static int cell_of(int x, int y, int z) { return x + kReach + kSpan * row_of(y, z); }

  std::vector<Sample> samples_;
  std::uint32_t start_[kSpan * kSpan * kSpan + 1];
  std::uint32_t occupied_[kSpan * kSpan];  ///< of a row: bit x + kReach, where samples are
};

/// Points of one voxel whose neighbours are sought; lanes past `count` repeat the last.
struct Queries {
  int count;
  VecRows position, gradient;
  std::array<int, 3> voxel;
};

/// Of each lane the nearest neighbours: the samples of one voxel that agree with the point, at
/// their mean, in voxel lengths from the point; nearest first, ties by the index of the voxel's
/// first sample.
class NearestRows {
 public:
  static constexpr int kMost = 64 + 1;  // with the point's own voxel

  explicit NearestRows(int capacity) : capacity_(capacity) {}

  /// Skips voxels that are farther from every point than what is at hand.
  void find(std::span<const Neighbourhood::Candidate> candidates, const Queries& queries,
            const Scale& scale) {
    const auto gaps = squared_gaps(queries, scale);
    std::fill_n(count_, 8, 0);
    std::fill_n(farthest_, 8, std::numeric_limits<float>::infinity());
    for (const Neighbourhood::Candidate& candidate : candidates) {
      const auto [x, y, z] = candidate.place;
      const Row gap = (gaps[0][x] + gaps[1][y]) + gaps[2][z];
      if (RowLanes::any(gap <= kSafe * load_row(farthest_)))
        look_at(candidate.samples, queries, scale);
    }
  }

  int count(int lane) const { return count_[lane]; }
  const Vec& offset(int lane, int i) const { return offset_[lane][slot_[lane][i]]; }

 private:
  static constexpr float kSafe = 1.001f;  // covers the rounding of distances
  using Gaps = std::array<std::array<Row, Neighbourhood::kBlock>, 3>;

  /// Squares of the distances from the points to the slabs of voxels round their own.
  static Gaps squared_gaps(const Queries& queries, const Scale& scale) {
    Gaps gaps;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (int i = 0; i < Neighbourhood::kBlock; ++i) {
        const auto voxel = static_cast<float>(queries.voxel[axis] + i - Neighbourhood::kReach);
        const Row below = voxel - queries.position[axis];
        const Row above = queries.position[axis] - (voxel + 1.0f);
        const Row outside = below < above ? above : below;
        const Row gap = where(outside > 0.0f, outside) * scale[axis];
        gaps[axis][i] = gap * gap;
      }
    return gaps;
  }

  /// Offers the neighbour that one voxel's samples make to each lane that one of them agrees with.
  void look_at(std::span<const Neighbourhood::Sample> samples, const Queries& queries,
               const Scale& scale) {
    VecRows sum{};
    Row agreeing{};
    for (const Neighbourhood::Sample& sample : samples) {
      const Vec& g = sample.gradient;
      const VecRows& own = queries.gradient;
      const RowMask agrees = (g[0] * own[0] + g[1] * own[1]) + g[2] * own[2] > kSameSheetGradients;
      for (std::size_t axis = 0; axis < 3; ++axis)
        sum[axis] += where(agrees, sample.position[axis] - queries.position[axis]);
      agreeing += where(agrees, Row{1, 1, 1, 1, 1, 1, 1, 1});
    }
    VecRows offset;  // not a number where none agrees
    for (std::size_t axis = 0; axis < 3; ++axis)
      offset[axis] = (sum[axis] / agreeing) * scale[axis];
    const Row distance = dot(offset, offset);
    for (int lane = 0; lane < queries.count; ++lane)
      if (distance[lane] <= farthest_[lane])
        insert(lane, distance[lane], samples.front().index,
               {offset[0][lane], offset[1][lane], offset[2][lane]});
  }

  void insert(int lane, float distance, std::uint32_t index, const Vec& offset) {
    std::uint64_t* keys = key_[lane];
    std::uint8_t* slots = slot_[lane];
    // squares are ordered as their bits are
    const std::uint64_t key = std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 32 | index;
    const bool full = count_[lane] == capacity_;
    if (full && key > keys[capacity_ - 1]) return;
    int i = full ? capacity_ - 1 : count_[lane]++;
    const auto slot = full ? slots[i] : static_cast<std::uint8_t>(i);
    for (; i > 0 && key < keys[i - 1]; --i) {
      keys[i] = keys[i - 1];
      slots[i] = slots[i - 1];
    }
    keys[i] = key;
    slots[i] = slot;
    offset_[lane][slot] = offset;
    if (count_[lane] == capacity_)
      farthest_[lane] = std::bit_cast<float>(static_cast<std::uint32_t>(keys[capacity_ - 1] >> 32));
  }

  int capacity_;
  int count_[8];
  float farthest_[8];  ///< square of the last one's distance where the lane is full
  std::uint64_t key_[8][kMost];
  std::uint8_t slot_[8][kMost];
  Vec offset_[8][kMost];
};

}  // namespace vasamesh

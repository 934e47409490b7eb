/// \file
/// The octree of real-like samples: what its levels cover, their tables against brute force, and
/// the range of its depth.

#include "stages/octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <unordered_set>

#include "stages/points.h"
#include "support/cases.h"
#include "support/dense_volume.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using Cell = std::array<int, 3>;

/// The cells of a level, found by their coordinates.
class CellSet {
 public:
  explicit CellSet(const OctreeLevel& level) {
    for (const BrickCoord& c : level.coords) bricks_.insert(key(c.x, c.y, c.z));
  }
  bool brick(int x, int y, int z) const { return bricks_.contains(key(x, y, z)); }
  bool cell(int x, int y, int z) const { return brick(x >> 3, y >> 3, z >> 3); }
  bool box(const Cell& first, const Cell& last) const {
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          if (!cell(x, y, z)) return false;
    return true;
  }

 private:
  static std::int64_t key(int x, int y, int z) {
    return x + 4096 + (std::int64_t{y} + 4096 + (std::int64_t{z} + 4096) * 8192) * 8192;
  }
  std::unordered_set<std::int64_t> bricks_;
};

Cell cell_of(const PointView& points, std::size_t i, int exponent) {
  Cell cell;
  for (std::size_t axis = 0; axis < 3; ++axis)
    cell[axis] = static_cast<int>(std::floor(std::ldexp(points.position[axis][i], -exponent)));
  return cell;
}

class OctreeLevels : public ::testing::Test {
 protected:
  void sample(const VolumeView& volume) {
    const BitVolume object = pack_volume(*backend_, volume);
    scale_ = make_scale(volume.geometry);
    points_ = extract_points(*backend_, object, scale_);
  }
  void sample_tree() { sample(tree_cases(3).back().make().view()); }
  Octree build(int depth = 0) {
    Parameters parameters;
    parameters.depth = depth;
    return build_octree(*backend_, points_, scale_, parameters);
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  PointCloud points_;
  Scale scale_{1, 1, 1};
};

/// Every sample below `thickness` has its three-cell neighbourhood at the level.
void expect_neighbourhoods(const PointView& points, const OctreeLevel& level, float thickness) {
  const CellSet cells(level);
  for (std::size_t i = 0; i < points.count; ++i) {
    if (points.thickness[i] >= thickness) continue;
    const Cell own = cell_of(points, i, level.exponent);
    ASSERT_TRUE(
        cells.box({own[0] - 3, own[1] - 3, own[2] - 3}, {own[0] + 3, own[1] + 3, own[2] + 3}))
        << "sample " << i << ", exponent " << level.exponent;
  }
}

TEST_F(OctreeLevels, EverySampleHasItsNeighbourhood) {
  sample_tree();
  const Octree octree = build();
  ASSERT_TRUE(octree.has_refined());
  expect_neighbourhoods(points_.view(), octree.at_exponent(0), 2.0f);
  expect_neighbourhoods(points_.view(), octree.at_exponent(-1), kThinThickness);
}

TEST_F(OctreeLevels, ParentsAndFourCellsRoundThem) {
  sample_tree();
  const Octree octree = build();
  for (std::size_t i = 1; i < octree.levels.size(); ++i) {
    const OctreeLevel& level = octree.levels[i];
    ASSERT_EQ(level.exponent, octree.levels[i - 1].exponent - 1);
    const CellSet coarser(octree.levels[i - 1]);
    const int room = level.exponent < 0 ? 0 : 4;
    for (const BrickCoord& c : level.coords)  // its 4^3 parent cells from 4 c on
      ASSERT_TRUE(coarser.box({4 * c.x - room, 4 * c.y - room, 4 * c.z - room},
                              {4 * c.x + 3 + room, 4 * c.y + 3 + room, 4 * c.z + 3 + room}))
          << "exponent " << level.exponent;
  }
}

TEST_F(OctreeLevels, RootIsSmall) {
  sample_tree();
  const Octree octree = build();
  EXPECT_GE(octree.root_exponent(), 2);
  for (const BrickCoord& c : octree.levels.front().coords)
    EXPECT_TRUE(std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)}) <= 1);
  EXPECT_EQ(octree.depth(octree.levels.front()), 4);
  EXPECT_EQ(octree.depth(octree.at_exponent(0)), 4 + octree.root_exponent());
}

TEST_F(OctreeLevels, FinestOnlyWhereThin) {
  sample(make_phantom("line_axis").view());
  const Octree octree = build();
  const CellSet refined(octree.at_exponent(-1));
  const PointView points = points_.view();
  std::size_t thick_alone = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    const Cell own = cell_of(points, i, -1);
    thick_alone += points.thickness[i] >= kThinThickness && !refined.cell(own[0], own[1], own[2]);
  }
  EXPECT_GT(thick_alone, points.count / 100) << "the refined level covers everything";
  int with_leaves = 0;
  for (std::size_t i = 0; i < octree.levels.size(); ++i) {
    const std::size_t children =
        i + 1 < octree.levels.size() ? octree.levels[i + 1].coords.size() : 0;
    with_leaves += 8 * octree.levels[i].coords.size() > children;
  }
  EXPECT_GE(with_leaves, 2);
}

TEST_F(OctreeLevels, UnknownCellsAndTablesAsByBruteForce) {
  const test::DenseVolume volume = test::random_volume({21, 13, 9}, 0.02, 4);
  sample(volume.view());
  const Octree octree = build();
  for (std::size_t i = 0; i < octree.levels.size(); ++i) {
    const OctreeLevel& level = octree.levels[i];
    const CellSet cells(level);
    std::size_t known = 0;
    for (std::size_t b = 0; b < level.coords.size(); ++b)
      for (int c = 0; c < kBrickCells; ++c) {
        const int x = 8 * level.coords[b].x + c % 8, y = 8 * level.coords[b].y + c / 8 % 8,
                  z = 8 * level.coords[b].z + c / 64;
        const bool inner = cells.cell(x - 1, y, z) && cells.cell(x + 1, y, z) &&
                           cells.cell(x, y - 1, z) && cells.cell(x, y + 1, z) &&
                           cells.cell(x, y, z - 1) && cells.cell(x, y, z + 1);
        ASSERT_EQ(level.unknown.view().data()[kBrickCells * b + static_cast<std::size_t>(c)],
                  inner || i == 0);
        known += !inner;
      }
    EXPECT_GT(known, 0u);
    if (i == 0) continue;
    const std::vector<BrickCoord>& coarse = octree.levels[i - 1].coords;
    for (std::size_t b = 0; b < level.coords.size(); ++b)
      for (int n = 0; n < 27; ++n) {
        const BrickCoord c = level.coords[b];
        const BrickCoord want = {(c.x >> 1) + n % 3 - 1, (c.y >> 1) + n / 3 % 3 - 1,
                                 (c.z >> 1) + n / 9 - 1};
        const auto found = std::find(coarse.begin(), coarse.end(), want);
        ASSERT_EQ(level.parents.view().data()[27 * b + static_cast<std::size_t>(n)],
                  found == coarse.end() ? kNoBrick : found - coarse.begin());
      }
  }
}

TEST_F(OctreeLevels, WeightsAreThoseOfTheBoxes) {
  test::DenseVolume volume = test::DenseVolume({9, 9, 9}).box({2, 2, 2}, {6, 6, 6});
  VolumeView view = volume.view();
  view.geometry.spacing = {0.5, 1.0, 2.0};
  sample(view);
  for (const OctreeLevel& level : build().levels)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double side = 0.5 * std::ldexp(1.0, static_cast<int>(axis) + level.exponent);
      EXPECT_NEAR(level.weights[axis], std::ldexp(1.0, 3 * level.exponent) / (side * side),
                  1e-5 * level.weights[axis]);
    }
}

/// The first point of each voxel within the index's bricks is that of the point cloud's.
TEST_F(OctreeLevels, PointIndexReachesOneBrickOfPointsFurther) {
  sample_tree();
  Octree octree = build();
  std::vector<BrickCoord> with_points(points_.bricks.count);
  backend_->download<BrickCoord>(points_.bricks.coords.view(), with_points);
  for (const int exponent : {1, 0, -1}) {
    const OctreeLevel& level = octree.at_exponent(exponent);
    const LevelPoints index = index_points(*backend_, level, points_);
    ASSERT_EQ(index.side, exponent == 1 ? 4 : 3);
    const auto side = static_cast<std::size_t>(index.side);
    std::size_t entry = 0;
    for (std::size_t b = 0; b < level.coords.size(); b += 7) {
      const auto base = [&](int c) {
        return static_cast<int>(std::floor(std::ldexp(c, exponent))) - 1;
      };
      entry = side * side * side * b;
      for (int z = 0; z < index.side; ++z)
        for (int y = 0; y < index.side; ++y)
          for (int x = 0; x < index.side; ++x, ++entry) {
            const BrickCoord want = {base(level.coords[b].x) + x, base(level.coords[b].y) + y,
                                     base(level.coords[b].z) + z};
            const auto found = std::find(with_points.begin(), with_points.end(), want);
            ASSERT_EQ(index.bricks.view().data()[entry],
                      found == with_points.end() ? kNoBrick : found - with_points.begin());
          }
    }
  }
}

TEST_F(OctreeLevels, DepthSaysHowFine) {
  sample_tree();
  const Octree automatic = build();
  const int regular = automatic.depth(automatic.at_exponent(0));
  for (int depth = regular - 2; depth <= regular; ++depth)
    EXPECT_FALSE(build(depth).has_refined()) << depth;
  const Octree finest = build(regular + 1);
  ASSERT_TRUE(finest.has_refined());
  expect_neighbourhoods(points_.view(), finest.at_exponent(-1), 2.0f);
  for (const int depth : {1, regular - 3, regular + 2}) {
    try {
      build(depth);
      ADD_FAILURE() << depth;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      EXPECT_NE(std::string(error.what()).find("depth"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(std::to_string(regular)), std::string::npos);
    }
  }
}

TEST_F(OctreeLevels, ThickVesselsHaveNoRefinedLevel) {
  const test::DenseVolume volume = test::DenseVolume({20, 20, 20}).box({3, 3, 3}, {16, 16, 16});
  sample(volume.view());
  const Octree octree = build();
  EXPECT_FALSE(octree.has_refined());
  expect_neighbourhoods(points_.view(), octree.at_exponent(0), 2.0f);
}

}  // namespace
}  // namespace vasamesh

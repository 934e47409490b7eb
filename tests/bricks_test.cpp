/// \file
/// Brick tables against brute force.

#include "stages/bricks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/backend_test.h"
#include "support/brick_sets.h"

namespace vasamesh {

/// Tells the coordinates in a failure.
void PrintTo(const BrickCoord& c, std::ostream* out) {
  *out << "(" << c.x << ", " << c.y << ", " << c.z << ")";
}

namespace {

std::int32_t find_plainly(const std::vector<BrickCoord>& bricks, const BrickCoord& wanted) {
  const auto found = std::find(bricks.begin(), bricks.end(), wanted);
  return found == bricks.end() ? kNoBrick : static_cast<std::int32_t>(found - bricks.begin());
}

std::vector<std::int32_t> windows_plainly(const std::vector<BrickCoord>& corners, int side,
                                          const std::vector<BrickCoord>& bricks) {
  std::vector<std::int32_t> table;
  for (const BrickCoord& c : corners)
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
          table.push_back(find_plainly(bricks, {c.x + x, c.y + y, c.z + z}));
  return table;
}

std::vector<BrickCoord> random_corners(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto any = [&] { return static_cast<int>(random() % 25) - 14; };
  std::vector<BrickCoord> corners;
  for (int i = 0; i < count; ++i) corners.push_back({any(), any(), any()});
  return corners;
}

class BrickTables : public BackendTest {};

TEST_P(BrickTables, NeighboursOfEach) {
  for (const int count : {1, 2, 27, 301}) {
    SCOPED_TRACE(count);
    const std::vector<BrickCoord> coords = random_bricks(count, 5);
    const Bricks bricks = make_bricks(backend(), coords);
    ASSERT_EQ(bricks.count, coords.size());
    EXPECT_EQ(to_host(backend(), bricks.coords.view()), coords);
    std::vector<BrickCoord> corners = coords;
    for (BrickCoord& c : corners) c = {c.x - 1, c.y - 1, c.z - 1};
    const auto neighbours = to_host(backend(), bricks.neighbours.view());
    EXPECT_EQ(neighbours, windows_plainly(corners, 3, coords));
    for (std::size_t b = 0; b < coords.size(); ++b)
      EXPECT_EQ(neighbours[27 * b + 13], static_cast<std::int32_t>(b));
  }
}

TEST_P(BrickTables, WindowsOfEverySide) {
  const std::vector<BrickCoord> bricks = random_bricks(257, 9), corners = random_corners(600, 3);
  for (int side = 1; side <= 8; ++side) {
    SCOPED_TRACE(side);
    const auto windows = brick_windows(backend(), corners, side, bricks);
    EXPECT_EQ(to_host(backend(), windows.view()), windows_plainly(corners, side, bricks));
  }
}

TEST_P(BrickTables, NothingAmongNothing) {
  EXPECT_EQ(make_bricks(backend(), {}).count, 0u);
  const std::vector<BrickCoord> corners = random_corners(3, 1);
  const auto none = brick_windows(backend(), corners, 2, {});
  EXPECT_EQ(to_host(backend(), none.view()), std::vector<std::int32_t>(24, kNoBrick));
  EXPECT_EQ(brick_windows(backend(), {}, 3, random_bricks(3, 1)).size(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Backends, BrickTables, ::testing::ValuesIn(backend_names()), test_name);

TEST(BrickSets, RasterOrderWithoutDuplicates) {
  std::vector<BrickCoord> coords = random_corners(4000, 11);
  std::vector<BrickCoord> want;
  for (int z = -14; z <= 10; ++z)
    for (int y = -14; y <= 10; ++y)
      for (int x = -14; x <= 10; ++x)
        if (find_plainly(coords, {x, y, z}) != kNoBrick) want.push_back({x, y, z});
  ASSERT_LT(want.size(), coords.size());
  sort_unique(coords);
  EXPECT_EQ(coords, want);
}

/// Whether the brick lies within four cells of an octant that is set.
bool within_four_cells(const BrickCoord& brick, const BrickCoord& of, std::uint8_t octants) {
  for (int octant = 0; octant < 8; ++octant) {
    if (!(octants >> octant & 1)) continue;
    const auto near = [&](int a, int b, int axis) {
      const int first = 8 * b + (octant >> axis & 1 ? 4 : 0);  // cells first .. first + 3
      return 8 * a <= first + 7 && 8 * a + 7 >= first - 4;
    };
    if (near(brick.x, of.x, 0) && near(brick.y, of.y, 1) && near(brick.z, of.z, 2)) return true;
  }
  return false;
}

TEST_P(BrickTables, DilatedByOctants) {
  const std::vector<BrickCoord> coords = random_bricks(40, 21);
  std::mt19937 random(2);
  std::vector<std::uint8_t> octants;
  for (std::size_t i = 0; i < coords.size(); ++i)
    octants.push_back(static_cast<std::uint8_t>(i % 5 == 0 ? 1u << random() % 8 : random() % 256));
  octants[3] = 0;
  std::vector<BrickCoord> want;
  for (int z = -12; z <= 12; ++z)
    for (int y = -12; y <= 12; ++y)
      for (int x = -12; x <= 12; ++x)
        for (std::size_t i = 0; i < coords.size(); ++i)
          if (within_four_cells({x, y, z}, coords[i], octants[i])) {
            want.push_back({x, y, z});
            break;
          }
  EXPECT_TRUE(dilate_by_octants(backend(), {}, {}).empty());
  EXPECT_EQ(dilate_by_octants(backend(), coords, octants), want);
}

}  // namespace
}  // namespace vasamesh

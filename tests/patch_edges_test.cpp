/// \file
/// Unequal edges made more equal: on plane grids by hand and at random.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh::test {
namespace {

constexpr std::uint32_t kSide = 9;  // vertices

PatchMesh patch_of(const std::vector<Vec3>& places, const std::vector<std::uint32_t>& corners,
                   std::vector<std::uint8_t> whole) {
  std::vector<SurfacePoint> points;
  for (const Vec3& p : places) points.push_back({p, {0, 0, 1}, 1});
  PatchMesh patch;
  patch.build(std::move(points), corners, std::move(whole));
  return patch;
}

/// A plane grid of equilateral triangles with edges of 1, each inner vertex moved by up to `shake`;
/// those on the border stay where they are.
struct Grid {
  std::vector<Vec3> places;
  std::vector<std::uint32_t> corners;
  std::vector<std::uint8_t> whole;

  explicit Grid(float shake, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> move(-shake, shake);
    for (std::uint32_t y = 0; y < kSide; ++y)
      for (std::uint32_t x = 0; x < kSide; ++x) {
        const bool inner = x > 0 && x + 1 < kSide && y > 0 && y + 1 < kSide;
        const float dx = move(random), dy = move(random);
        places.push_back({static_cast<float>(x) + 0.5f * static_cast<float>(y) + (inner ? dx : 0),
                          0.8660254f * static_cast<float>(y) + (inner ? dy : 0), 8});
        whole.push_back(inner);
      }
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
      for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
        const std::uint32_t v = y * kSide + x;
        corners.insert(corners.end(), {v, v + 1, v + kSide, v + 1, v + kSide + 1, v + kSide});
      }
  }
  PatchMesh patch() const { return patch_of(places, corners, whole); }
};

template <class Visit>
void for_each_triangle(const PatchMesh& patch, const Visit& visit) {
  for (std::uint32_t h = 0; h < patch.half_edge_end(); h += 4)
    if (patch.is_edge(h))
      visit(patch.points[patch.origin(h)], patch.points[patch.target(h)],
            patch.points[patch.apex(h)]);
}

int uneven_triangles(const PatchMesh& patch) {
  int count = 0;
  for_each_triangle(
      patch, [&](const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
        count += squared_edge_ratio(a.position, b.position, c.position) < kLeastSquaredEdgeRatio;
      });
  return count;
}

float least_squared_sine_of(const PatchMesh& patch) {
  float least = 1;
  for_each_triangle(patch,
                    [&](const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
                      least = std::min(least, least_squared_sine(a, b, c));
                    });
  return least;
}

/// The sum of the triangles' areas if none is turned over, and less than nothing if one is.
float area_of(const PatchMesh& patch) {
  float area = 0;
  bool turned = false;
  for_each_triangle(
      patch, [&](const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
        const float own = cross(b.position - a.position, c.position - a.position).z / 2;
        turned = turned || own <= 0;
        area += own;
      });
  return turned ? -1 : area;
}

TEST(PatchEdges, EqualityIsTheSquaredRatioOfShortestToLongest) {
  EXPECT_FLOAT_EQ(squared_edge_ratio({0, 0, 0}, {3, 0, 0}, {0, 4, 0}), 9.0f / 25);
  EXPECT_FLOAT_EQ(squared_edge_ratio({0, 4, 0}, {0, 0, 0}, {3, 0, 0}), 9.0f / 25);
  EXPECT_FLOAT_EQ(squared_edge_ratio({1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
  EXPECT_EQ(squared_edge_ratio({1, 1, 1}, {1, 1, 1}, {1, 1, 1}), 0);
  EXPECT_FLOAT_EQ(squared_edge_ratio({0, 0, 0}, {1.5f, 0, 0}, {1.5f, 1, 0}), 4.0f / 13);
}

TEST(PatchEdges, AVertexFarFromTheMiddleMovesTowardsIt) {
  Grid grid(0);
  const std::uint32_t v = 4 * kSide + 4;
  const Vec3 middle = grid.places[v];
  grid.places[v].x += 0.35f;
  PatchMesh patch = grid.patch();
  ASSERT_GT(uneven_triangles(patch), 0);
  even_edges(patch, 4);
  EXPECT_EQ(uneven_triangles(patch), 0);
  EXPECT_LT(norm(patch.points[v].position - middle), 0.3f);
  EXPECT_FALSE(patch.points[v].on_field);
}

TEST(PatchEdges, ALongEdgeTurns) {
  const std::vector<Vec3> places = {{0, 0, 8}, {1.7f, 0, 8}, {0.85f, 0.5f, 8}, {0.85f, -0.5f, 8}};
  PatchMesh patch = patch_of(places, {0, 1, 2, 1, 0, 3}, {1, 1, 1, 1});
  ASSERT_EQ(uneven_triangles(patch), 2);
  even_edges(patch, 1);
  EXPECT_EQ(uneven_triangles(patch), 0);
}

TEST(PatchEdges, ABentEdgeDoesNotTurn) {
  // The same edge as the ridge of a roof: turned, it would lie far below.
  const std::vector<Vec3> places = {
      {0, 0, 8}, {1.7f, 0, 8}, {0.85f, 0.4f, 7.6f}, {0.85f, -0.4f, 7.6f}};
  PatchMesh patch = patch_of(places, {0, 1, 2, 1, 0, 3}, {1, 1, 1, 1});
  even_edges(patch, 4);
  EXPECT_EQ(patch.origin(0), 0u);
  EXPECT_EQ(patch.target(0), 1u);
}

TEST(PatchEdges, EvenTrianglesStayAsTheyAre) {
  const Grid grid(0.05f);
  PatchMesh patch = grid.patch();
  ASSERT_EQ(uneven_triangles(patch), 0);
  even_edges(patch, 4);
  for (std::size_t v = 0; v < grid.places.size(); ++v)
    EXPECT_EQ(patch.points[v].position, grid.places[v]);
}

TEST(PatchEdges, ShakenGridsBecomeEvenWithoutAFold) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    PatchMesh patch = Grid(0.25f, seed).patch();
    const int before = uneven_triangles(patch);
    const float squared_sine = least_squared_sine_of(patch), area = area_of(patch);
    ASSERT_GT(area, 0) << "seed " << seed;
    ASSERT_GT(before, 5) << "seed " << seed;
    even_edges(patch, 8);
    EXPECT_LE(uneven_triangles(patch), before / 5) << "seed " << seed;
    EXPECT_GE(least_squared_sine_of(patch), std::min(squared_sine, kSquaredSine25))
        << "seed " << seed;
    EXPECT_NEAR(area_of(patch), area, 1e-3f) << "seed " << seed;
  }
}

TEST(PatchEdges, NothingMovesIntoAnotherSheet) {
  // The vertex off the middle, and a wall that stands through the grid beside it.
  Grid grid(0);
  const std::uint32_t v = 4 * kSide + 4;
  grid.places[v].x += 0.35f;
  const float wall = grid.places[v].x - 0.04f;
  const auto first = static_cast<std::uint32_t>(grid.places.size());
  for (const Vec3& p :
       {Vec3{wall, 3, 8.5f}, Vec3{wall, 4, 8.5f}, Vec3{wall, grid.places[v].y, 7.5f}})
    grid.places.push_back(p), grid.whole.push_back(0);
  grid.corners.insert(grid.corners.end(), {first, first + 1, first + 2});
  PatchMesh patch = grid.patch();
  even_edges(patch, 4);
  EXPECT_EQ(patch.points[v].position, grid.places[v]);
}

}  // namespace
}  // namespace vasamesh::test

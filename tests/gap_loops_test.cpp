/// \file
/// The loops round the gaps of open surfaces, and what tells discs from annuli.

#include "stages/gap_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "support/gaps.h"
#include "types/angles.h"
#include "vasamesh/errors.h"

namespace vasamesh::test {
namespace {

/// The edges that gaps must have: those whose other direction alone is in a triangle.
std::multiset<Edge> boundary(const TriangleMesh& mesh) {
  const std::multiset<Edge> edges = directed_edges(mesh);
  std::multiset<Edge> open;
  for (const auto& [a, b] : edges)
    if (!edges.contains({b, a})) open.insert({b, a});
  return open;
}

std::multiset<Edge> edges_of(const GapLoops& loops) {
  std::multiset<Edge> edges;
  for (std::size_t l = 0; l < loops.count(); ++l)
    for (std::size_t i = 0; i < loops.size(l); ++i)
      edges.insert({loops[l][i], loops[l][(i + 1) % loops.size(l)]});
  return edges;
}

TEST(GapLoops, OfAClosedSurfaceAreNone) {
  EXPECT_EQ(find_gap_loops(two_threads(), ball().mesh).count(), 0u);
  EXPECT_EQ(find_gap_loops(two_threads(), TriangleMesh{}).count(), 0u);
}

TEST(GapLoops, RunAgainstTheTriangles) {
  TriangleMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  mesh.triangles = {0, 1, 2, 0, 2, 3};
  const GapLoops loops = find_gap_loops(two_threads(), mesh);
  EXPECT_EQ(loops.vertex, (std::vector<std::uint32_t>{0, 3, 2, 1}));
  EXPECT_EQ(loops.first, (std::vector<std::uint32_t>{0, 4}));
}

TEST(GapLoops, CoverTheBoundaryOnce) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const TriangleMesh mesh = with_random_holes(ring().mesh, 25, 40, seed);
    EXPECT_EQ(edges_of(find_gap_loops(two_threads(), mesh)), boundary(mesh)) << "seed " << seed;
  }
}

TEST(GapLoops, GapsThatTouchAreTwo) {
  // Two triangles removed that share a vertex alone: two gaps there, not one.
  TriangleMesh mesh;
  add_vertex(mesh, {0, 0, 0});
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * i / 3;
    add_vertex(mesh, {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0});
  }
  for (std::uint32_t i : {1u, 2u, 4u, 5u}) add_triangle(mesh, 0, i, i + 1);
  const GapLoops loops = find_gap_loops(two_threads(), mesh);
  // Round the hexagon there is one loop more, joined to both gaps at their outer corners.
  ASSERT_EQ(loops.count(), 1u);
  EXPECT_EQ(edges_of(loops), boundary(mesh));
  EXPECT_EQ(std::count(loops.vertex.begin(), loops.vertex.end(), 0u), 2);
  const std::size_t at =
      std::find(loops.vertex.begin(), loops.vertex.end(), 0u) - loops.vertex.begin();
  // Each visit crosses one gap: from the fan's end to the next fan's start.
  const std::size_t n = loops.vertex.size();
  const Edge visit{loops.vertex[(at + n - 1) % n], loops.vertex[(at + 1) % n]};
  EXPECT_TRUE(visit == Edge(4, 3) || visit == Edge(1, 6)) << visit.first << " " << visit.second;
}

TEST(GapLoops, TrianglesThatDisagreeAreRefused) {
  TriangleMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  mesh.triangles = {0, 1, 2, 0, 3, 2};
  EXPECT_THROW(find_gap_loops(two_threads(), mesh), Error);
}

TEST(GapLoops, AnglesWithinTheirBound) {
  for (int i = -1000; i <= 1000; ++i) {
    const double angle = std::numbers::pi * (i + 0.5) / 1001;
    EXPECT_NEAR(
        angle_of(static_cast<float>(3 * std::cos(angle)), static_cast<float>(3 * std::sin(angle))),
        angle, 2e-5);
  }
  EXPECT_EQ(angle_of(0, 0), 0);
}

TEST(GapLoops, TurningTellsDiscsFromAnnuli) {
  Scene& tube = ring();
  const TriangleMesh hole = with_random_holes(tube.mesh, 1, 30, 3);
  const GapLoops one = find_gap_loops(two_threads(), hole);
  ASSERT_EQ(one.count(), 1u);
  EXPECT_GT(turning_of(tube.field, hole, one[0]), 1.5f * std::numbers::pi_v<float>);
  const TriangleMesh open =
      cut(tube.mesh, [](const Vec3& p) { return p.x > 16 && std::abs(p.y - 16) < 1; });
  const GapLoops two = find_gap_loops(two_threads(), open);
  ASSERT_EQ(two.count(), 2u);
  for (std::size_t l = 0; l < 2; ++l) EXPECT_NEAR(turning_of(tube.field, open, two[l]), 0, 0.8);
}

}  // namespace
}  // namespace vasamesh::test

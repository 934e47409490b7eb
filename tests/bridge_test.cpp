/// \file
/// Gaps of more than one loop, and the ends of tubes: what is joined, and what stays open.

#include "stages/bridge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/gaps.h"
#include "support/invariants.h"

namespace vasamesh::test {
namespace {

TEST(Stitch, AnnulusIsBridged) {
  TriangleMesh mesh =
      cut(ring().mesh, [](const Vec3& p) { return p.x > 16 && std::abs(p.y - 16) < 1; });
  const StitchReport report = stitch(ring(), mesh);
  EXPECT_EQ(report.loops, 2);
  EXPECT_EQ(report.bridges, 1);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 1, 0});
}

TEST(Stitch, ATubeCutInTwoIsJoined) {
  TriangleMesh mesh = cut(ring().mesh, [](const Vec3& p) { return std::abs(p.y - 16) < 1; });
  const StitchReport report = stitch(ring(), mesh);
  EXPECT_EQ(report.loops, 4);
  EXPECT_EQ(report.bridges, 2);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 1, 0});
}

TEST(Stitch, HemispheresAreJoined) {
  TriangleMesh mesh = cut(ball().mesh, [](const Vec3& p) { return std::abs(p.z - 12) < 0.8f; });
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_EQ(report.bridges, 1);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 0, 0});
}

TEST(Stitch, AnIslandIsJoinedToItsShore) {
  // A bow tie of two triangles that touch at one vertex, inside a hole: its loop passes there
  // twice.
  const TriangleMesh& whole = ball().mesh;
  std::vector<std::vector<std::uint32_t>> at_vertex(whole.vertex_count());
  for (std::size_t c = 0; c < whole.triangles.size(); ++c)
    at_vertex[whole.triangles[c]].push_back(static_cast<std::uint32_t>(c / 3));
  const std::uint32_t middle = 300;
  std::vector<bool> near(whole.vertex_count(), false), removed(whole.triangle_count(), false);
  near[middle] = true;
  for (int ring = 0; ring < 2; ++ring) {
    std::vector<bool> grown = near;
    for (std::size_t c = 0; c < whole.triangles.size(); ++c)
      if (near[whole.triangles[c]])
        for (int i = 0; i < 3; ++i) grown[whole.triangles[c / 3 * 3 + i]] = true;
    near = grown;
  }
  for (std::size_t c = 0; c < whole.triangles.size(); ++c)
    if (near[whole.triangles[c]]) removed[c / 3] = true;
  const std::uint32_t first = at_vertex[middle][0];
  removed[first] = false;
  for (const std::uint32_t t : at_vertex[middle]) {
    int shared = 0;
    for (int i = 0; i < 9; ++i)
      shared += whole.triangles[3 * first + i / 3] == whole.triangles[3 * t + i % 3];
    if (shared != 1) continue;
    removed[t] = false;
    break;
  }
  TriangleMesh mesh = without(whole, removed);
  const GapLoops loops = find_gap_loops(two_threads(), mesh);
  ASSERT_EQ(loops.count(), 2u);
  ASSERT_EQ(std::min(loops.size(0), loops.size(1)), 6u);
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_EQ(report.bridges, 1);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 0, 0});
}

TEST(Stitch, AVesselsEndGetsItsTip) {
  // Half of a ball of radius 1: its rim hardly turns, as if it went round a tube.
  Scene end{sphere_field(12, {6, 6, 6}, 1), moved(sphere(1, 1), {6, 6, 6}), 1};
  TriangleMesh mesh = cut(end.mesh, [](const Vec3& p) { return p.y > 6; });
  const GapLoops loops = find_gap_loops(two_threads(), mesh);
  ASSERT_EQ(loops.count(), 1u);
  EXPECT_LT(turning_of(end.field, mesh, loops[0]), kLeastTurning);
  const StitchReport report = stitch(end, mesh);
  EXPECT_TRUE(report.open.empty());
  EXPECT_EQ(report.starred, 1);
  expect_good_surface(mesh, {1, 0, 0});
}

TEST(Stitch, ATubesEndIsNotCapped) {
  // Half a torus: both ends lack a partner within reach.
  TriangleMesh mesh = cut(ring().mesh, [](const Vec3& p) { return p.y > 16; });
  const TriangleMesh before = mesh;
  const StitchReport report = stitch(ring(), mesh);
  EXPECT_EQ(report.open.size(), 2u);
  EXPECT_EQ(mesh.triangles, before.triangles);
  EXPECT_EQ(mesh.vertices, before.vertices);
}

TEST(Stitch, AThinTubesEndIsNotCapped) {
  const auto try_tube = [](float radius, int around) {
    Scene thin{torus_field(20, {10, 10, 10}, 6, radius),
               moved(torus(6, radius, 40, around), {10, 10, 10}), 1};
    for (const StitchMode mode : {StitchMode::exact, StitchMode::paper}) {
      TriangleMesh mesh = cut(thin.mesh, [](const Vec3& p) { return p.y > 10; });
      const StitchReport report = stitch(thin, mesh, mode);
      EXPECT_EQ(report.loops, 2) << radius;
      EXPECT_EQ(report.open.size(), 2u) << radius;
      EXPECT_EQ(mesh.triangle_count(), report.first_triangle) << radius;
    }
  };
  try_tube(0.5f, 3);
  try_tube(0.6f, 4);
  try_tube(0.8f, 5);
  try_tube(1.2f, 8);
  try_tube(1.6f, 10);
}

TEST(Stitch, AThinTubeIsJoined) {
  Scene thin{torus_field(20, {10, 10, 10}, 6, 0.8f), moved(torus(6, 0.8f, 40, 5), {10, 10, 10}), 1};
  TriangleMesh mesh =
      cut(thin.mesh, [](const Vec3& p) { return p.x > 10 && std::abs(p.y - 10) < 1; });
  const StitchReport report = stitch(thin, mesh);
  EXPECT_EQ(report.bridges, 1);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 1, 0});
}

}  // namespace
}  // namespace vasamesh::test

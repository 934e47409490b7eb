/// \file
/// Gap stitching: holes cut out of closed surfaces are closed again, with the same topology. Their
/// loops: gap_loops_test.cpp; loops that are joined: bridge_test.cpp.

#include "stages/stitch.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <set>
#include <vector>

#include "stages/quality.h"
#include "support/gaps.h"
#include "support/invariants.h"
#include "vasamesh/errors.h"

namespace vasamesh::test {
namespace {

void expect_closed(Scene& scene, TriangleMesh mesh, const Topology& wanted,
                   StitchMode mode = StitchMode::exact) {
  const TriangleMesh before = mesh;
  const StitchReport report = stitch(scene, mesh, mode);
  EXPECT_TRUE(report.open.empty()) << report.open.size() << " gaps of " << report.loops;
  expect_good_surface(mesh, wanted);
  ASSERT_EQ(report.first_triangle, before.triangle_count());
  ASSERT_EQ(report.first_vertex, before.vertex_count());
  EXPECT_TRUE(std::equal(before.triangles.begin(), before.triangles.end(), mesh.triangles.begin()));
  EXPECT_TRUE(std::equal(before.vertices.begin(), before.vertices.end(), mesh.vertices.begin()));
}

// --- Closing. -----------------------------------------------------------------------------------

TEST(Stitch, NothingToDo) {
  TriangleMesh mesh = ball().mesh;
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_EQ(report.loops, 0);
  EXPECT_EQ(mesh.triangles, ball().mesh.triangles);
  EXPECT_EQ(mesh.vertices, ball().mesh.vertices);
}

TEST(Stitch, OneTriangleAndTwo) {
  for (const StitchMode mode : {StitchMode::exact, StitchMode::paper}) {
    std::vector<bool> removed(ball().mesh.triangle_count());
    removed[100] = true;
    expect_closed(ball(), without(ball().mesh, removed), {1, 0, 0}, mode);
    // Triangles 4 k + 3 lie in the middle of 4 k .. 4 k + 2.
    removed[103] = true;
    TriangleMesh mesh = without(ball().mesh, removed);
    EXPECT_EQ(find_gap_loops(two_threads(), mesh).size(0), 4u);
    stitch(ball(), mesh, mode);
    EXPECT_EQ(mesh.triangle_count(), ball().mesh.triangle_count());
    expect_good_surface(mesh, {1, 0, 0});
  }
}

class RandomHoles : public ::testing::TestWithParam<unsigned> {};

TEST_P(RandomHoles, InASphere) {
  expect_closed(ball(), with_random_holes(ball().mesh, 12, 30, GetParam()), {1, 0, 0});
}

TEST_P(RandomHoles, InATorus) {
  expect_closed(ring(), with_random_holes(ring().mesh, 20, 40, GetParam()), {1, 1, 0});
}

TEST_P(RandomHoles, InATorusAsThePaperDoes) {
  expect_closed(ring(), with_random_holes(ring().mesh, 20, 25, GetParam()), {1, 1, 0},
                StitchMode::paper);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomHoles, ::testing::Range(0u, 12u));

TEST(Stitch, LongLoopIsSplit) {
  // A slit of one row of quadrilaterals, 100 long.
  Scene scene{torus_field(52, {26, 26, 26}, 20, 4), moved(torus(20, 4, 126, 25), {26, 26, 26}),
              1.3f};
  std::vector<bool> removed(scene.mesh.triangle_count());
  for (int i = 0; i < 100; ++i) removed[50 * i] = removed[50 * i + 1] = true;
  TriangleMesh mesh = without(scene.mesh, removed);
  const GapLoops loops = find_gap_loops(two_threads(), mesh);
  ASSERT_EQ(loops.count(), 1u);
  EXPECT_EQ(loops.size(0), 202u);
  const StitchReport report = stitch(scene, mesh);
  EXPECT_GE(report.splits, 1);
  EXPECT_TRUE(report.open.empty());
  EXPECT_EQ(mesh.triangle_count(), scene.mesh.triangle_count());
  expect_good_surface(mesh, {1, 1, 0});
}

TEST(Stitch, LargeGapIsFilledToTheDensityAroundIt) {
  TriangleMesh mesh = cut(ball().mesh, [](const Vec3& p) { return p.z > 16.5f; });
  const auto removed = static_cast<double>(ball().mesh.triangle_count() - mesh.triangle_count());
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 0, 0});
  const auto added = static_cast<double>(mesh.triangle_count() - report.first_triangle);
  EXPECT_NEAR(added / removed, 1, 0.3);
  for (std::size_t v = report.first_vertex; v < mesh.vertex_count(); ++v)
    EXPECT_NEAR(norm(vertex_at(mesh, static_cast<std::uint32_t>(v)) - Vec3{12, 12, 12}), 8, 0.05);
  EXPECT_GT(measure_quality(two_threads(), mesh).least_angle.minimum, 20);
}

TEST(Stitch, AHexagonGetsItsMiddle) {
  // All triangles round one vertex: six edges, whose best triangulation has 30 degrees.
  std::vector<bool> removed(ball().mesh.triangle_count());
  for (std::size_t c = 0; c < ball().mesh.triangles.size(); ++c)
    if (ball().mesh.triangles[c] == 300) removed[c / 3] = true;
  TriangleMesh mesh = without(ball().mesh, removed);
  stitch(ball(), mesh);
  EXPECT_EQ(mesh.triangle_count(), ball().mesh.triangle_count());
  EXPECT_EQ(mesh.vertex_count(), ball().mesh.vertex_count());
  expect_good_surface(mesh, {1, 0, 0});
  EXPECT_GT(measure_quality(two_threads(), mesh).least_angle.minimum, 45);
}

// --- What cannot be closed. ---------------------------------------------------------------------

TEST(Stitch, ALoneTriangleStaysOpen) {
  // Its gap is its own other side.
  TriangleMesh mesh;
  mesh.vertices = {12, 12, 20, 13, 12, 19.9f, 12, 13, 19.9f};
  mesh.triangles = {0, 1, 2};
  const StitchReport report = stitch(ball(), mesh);
  ASSERT_EQ(report.open.size(), 1u);
  EXPECT_EQ(report.open[0].vertices, (std::vector<std::uint32_t>{0, 2, 1}));
  EXPECT_EQ(report.open[0].reason, GapFailure::no_triangulation);
  EXPECT_EQ(mesh.triangle_count(), 1u);
}

TEST(Stitch, OutsideTheFieldNothingIsClosed) {
  TriangleMesh mesh = with_random_holes(moved(ball().mesh, {500, 0, 0}), 5, 20, 1);
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_EQ(static_cast<std::int64_t>(report.open.size()), report.loops);
}

TEST(Stitch, LoopsThatAreNotOnTheBoundaryAreRefused) {
  GapLoops loops;
  loops.add(std::vector<std::uint32_t>{0, 1, 2, 3});
  TriangleMesh mesh = ball().mesh;
  EXPECT_THROW(stitch_gaps(two_threads(), ball().field.view(), ball().field.sizes(1),
                           StitchMode::exact, loops, mesh),
               Error);
}

TEST(Stitch, OneEdgeForTwoGaps) {
  // Two flat gaps over each other, of the same short diagonal 0 - 2; the second takes its long one.
  AnalyticField plane = plane_field(12, 6);
  TriangleMesh mesh;
  mesh.vertices = {6, 5.6f, 6, 7, 6, 6, 6, 6.4f, 6, 5, 6, 6, 7.2f, 6, 6, 4.8f, 6, 6};
  GapLoops loops;
  loops.add(std::vector<std::uint32_t>{0, 1, 2, 3});
  loops.add(std::vector<std::uint32_t>{0, 4, 2, 5});
  for (std::size_t l = 0; l < 2; ++l)
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t a = loops[l][i], b = loops[l][(i + 1) % 4];
      const Vec3 middle = vertex_at(mesh, a) + vertex_at(mesh, b) - Vec3{6, 6, 6};
      add_triangle(mesh, b, a, add_vertex(mesh, {middle.x, middle.y, middle.z}));
    }
  const StitchReport report =
      stitch_gaps(two_threads(), plane.view(), plane.sizes(5), StitchMode::exact, loops, mesh);
  EXPECT_TRUE(report.open.empty());
  EXPECT_EQ(report.repeated, 1);
  const std::multiset<Edge> edges = directed_edges(mesh);
  EXPECT_EQ(edges.count({0, 2}) + edges.count({2, 0}), 2u);
  EXPECT_EQ(edges.count({4, 5}) + edges.count({5, 4}), 2u);
}

TEST(Stitch, SameForAnyNumberOfThreads) {
  // Four workers even where there are fewer cores.
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const TriangleMesh holes = with_random_holes(ring().mesh, 40, 25, 7);
  for (const StitchMode mode : {StitchMode::exact, StitchMode::paper}) {
    std::vector<TriangleMesh> results;
    for (const int threads : {1, 2, 4, 4}) {
      results.push_back(holes);
      stitch_gaps(*make_tbb_backend(threads, nullptr), ring().field.view(), ring().field.sizes(1),
                  mode, results.back());
      EXPECT_EQ(results.back().vertices, results[0].vertices);
      EXPECT_EQ(results.back().triangles, results[0].triangles);
    }
  }
}

}  // namespace
}  // namespace vasamesh::test

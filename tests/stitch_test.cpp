/// \file
/// Gap stitching: holes cut out of closed surfaces are closed again, with the same topology.

#include "stages/stitch.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "stages/bridge.h"
#include "stages/quality.h"
#include "support/analytic_field.h"
#include "support/invariants.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/angles.h"
#include "vasamesh/errors.h"

namespace vasamesh::test {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

Backend& backend() {
  static const std::shared_ptr<Backend> tbb = make_tbb_backend(2, nullptr);
  return *tbb;
}

/// A surface, the field whose zero set it samples, and the length of its edges.
struct Scene {
  AnalyticField field;
  TriangleMesh mesh;
  float size;
};

Scene& ball() {
  static Scene scene{sphere_field(24, {12, 12, 12}, 8), moved(sphere(8, 3), {12, 12, 12}), 1.15f};
  return scene;
}

Scene& ring() {
  static Scene scene{torus_field(32, {16, 16, 16}, 10, 3),
                     moved(torus(10, 3, 62, 19), {16, 16, 16}), 1.0f};
  return scene;
}

StitchReport stitch(Scene& scene, TriangleMesh& mesh, StitchMode mode = StitchMode::exact) {
  return stitch_gaps(backend(), scene.field.view(), scene.field.sizes(scene.size), mode, mesh);
}

/// The triangles that are not removed, and their vertices alone.
TriangleMesh without(const TriangleMesh& mesh, const std::vector<bool>& removed) {
  constexpr std::uint32_t kUnused = 0xffffffffu;
  std::vector<std::uint32_t> moved_to(mesh.vertex_count(), kUnused);
  TriangleMesh rest;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (removed[t]) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t v = mesh.triangles[3 * t + i];
      if (moved_to[v] == kUnused) {
        const float* p = mesh.vertices.data() + 3 * std::size_t{v};
        moved_to[v] = add_vertex(rest, {p[0], p[1], p[2]});
      }
      rest.triangles.push_back(moved_to[v]);
    }
  }
  return rest;
}

/// Without triangles of which `condition` holds for the centre.
template <class Condition>
TriangleMesh cut(const TriangleMesh& mesh, const Condition& condition) {
  std::vector<bool> removed(mesh.triangle_count());
  for (std::size_t t = 0; t < removed.size(); ++t) {
    Vec3 centre;
    for (int i = 0; i < 3; ++i)
      centre = centre + (1.0f / 3) * vertex_at(mesh, mesh.triangles[3 * t + i]);
    removed[t] = condition(centre);
  }
  return without(mesh, removed);
}

/// Removes patches of neighbouring triangles, each grown at random from a random triangle.
TriangleMesh with_random_holes(const TriangleMesh& mesh, int holes, int largest, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<std::uint32_t>> at_vertex(mesh.vertex_count());
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    at_vertex[mesh.triangles[c]].push_back(static_cast<std::uint32_t>(c / 3));
  std::vector<bool> removed(mesh.triangle_count(), false);
  for (int hole = 0; hole < holes; ++hole) {
    const std::size_t wanted = 1 + random() % largest;
    std::vector<std::uint32_t> patch{static_cast<std::uint32_t>(random() % mesh.triangle_count())};
    for (int trial = 0; patch.size() < wanted && trial < 20 * largest; ++trial) {
      const std::uint32_t from = patch[random() % patch.size()];
      const auto& near = at_vertex[mesh.triangles[3 * from + random() % 3]];
      const std::uint32_t to = near[random() % near.size()];
      int shared = 0;
      for (int i = 0; i < 9; ++i)
        shared += mesh.triangles[3 * from + i / 3] == mesh.triangles[3 * to + i % 3];
      if (shared == 2 && std::find(patch.begin(), patch.end(), to) == patch.end())
        patch.push_back(to);
    }
    for (const std::uint32_t t : patch) removed[t] = true;
  }
  return without(mesh, removed);
}

std::multiset<Edge> directed_edges(const TriangleMesh& mesh) {
  std::multiset<Edge> edges;
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    edges.insert({mesh.triangles[c], mesh.triangles[c % 3 == 2 ? c - 2 : c + 1]});
  return edges;
}

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

float turning_of(AnalyticField& field, const TriangleMesh& mesh,
                 std::span<const std::uint32_t> loop) {
  std::vector<Vec3> points, normals;
  for (const std::uint32_t v : loop) {
    points.push_back(vertex_at(mesh, v));
    normals.push_back(normalised(-sample_field(field.view(), points.back()).gradient));
  }
  return turning(points, normals);
}

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

// --- Loops. -------------------------------------------------------------------------------------

TEST(GapLoops, OfAClosedSurfaceAreNone) {
  EXPECT_EQ(find_gap_loops(backend(), ball().mesh).count(), 0u);
  EXPECT_EQ(find_gap_loops(backend(), TriangleMesh{}).count(), 0u);
}

TEST(GapLoops, RunAgainstTheTriangles) {
  TriangleMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  mesh.triangles = {0, 1, 2, 0, 2, 3};
  const GapLoops loops = find_gap_loops(backend(), mesh);
  EXPECT_EQ(loops.vertex, (std::vector<std::uint32_t>{0, 3, 2, 1}));
  EXPECT_EQ(loops.first, (std::vector<std::uint32_t>{0, 4}));
}

TEST(GapLoops, CoverTheBoundaryOnce) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const TriangleMesh mesh = with_random_holes(ring().mesh, 25, 40, seed);
    EXPECT_EQ(edges_of(find_gap_loops(backend(), mesh)), boundary(mesh)) << "seed " << seed;
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
  const GapLoops loops = find_gap_loops(backend(), mesh);
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
  EXPECT_THROW(find_gap_loops(backend(), mesh), Error);
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
  const GapLoops one = find_gap_loops(backend(), hole);
  ASSERT_EQ(one.count(), 1u);
  EXPECT_GT(turning_of(tube.field, hole, one[0]), 1.5f * std::numbers::pi_v<float>);
  const TriangleMesh open =
      cut(tube.mesh, [](const Vec3& p) { return p.x > 16 && std::abs(p.y - 16) < 1; });
  const GapLoops two = find_gap_loops(backend(), open);
  ASSERT_EQ(two.count(), 2u);
  for (std::size_t l = 0; l < 2; ++l) EXPECT_NEAR(turning_of(tube.field, open, two[l]), 0, 0.8);
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
    EXPECT_EQ(find_gap_loops(backend(), mesh).size(0), 4u);
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
  const GapLoops loops = find_gap_loops(backend(), mesh);
  ASSERT_EQ(loops.count(), 2u);
  ASSERT_EQ(std::min(loops.size(0), loops.size(1)), 6u);
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_EQ(report.bridges, 1);
  EXPECT_TRUE(report.open.empty());
  expect_good_surface(mesh, {1, 0, 0});
}

TEST(Stitch, LongLoopIsSplit) {
  // A slit of one row of quadrilaterals, 100 long.
  Scene scene{torus_field(52, {26, 26, 26}, 20, 4), moved(torus(20, 4, 126, 25), {26, 26, 26}),
              1.3f};
  std::vector<bool> removed(scene.mesh.triangle_count());
  for (int i = 0; i < 100; ++i) removed[50 * i] = removed[50 * i + 1] = true;
  TriangleMesh mesh = without(scene.mesh, removed);
  const GapLoops loops = find_gap_loops(backend(), mesh);
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
  EXPECT_GT(measure_quality(backend(), mesh).least_angle.minimum, 20);
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
  EXPECT_GT(measure_quality(backend(), mesh).least_angle.minimum, 45);
}

TEST(Stitch, AVesselsEndGetsItsTip) {
  // Half of a ball of radius 1: its rim hardly turns, as if it went round a tube.
  Scene end{sphere_field(12, {6, 6, 6}, 1), moved(sphere(1, 1), {6, 6, 6}), 1};
  TriangleMesh mesh = cut(end.mesh, [](const Vec3& p) { return p.y > 6; });
  const GapLoops loops = find_gap_loops(backend(), mesh);
  ASSERT_EQ(loops.count(), 1u);
  EXPECT_LT(turning_of(end.field, mesh, loops[0]), kLeastTurning);
  const StitchReport report = stitch(end, mesh);
  EXPECT_TRUE(report.open.empty());
  EXPECT_EQ(report.starred, 1);
  expect_good_surface(mesh, {1, 0, 0});
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

TEST(Stitch, OutsideTheFieldNothingIsClosed) {
  TriangleMesh mesh = with_random_holes(moved(ball().mesh, {500, 0, 0}), 5, 20, 1);
  const StitchReport report = stitch(ball(), mesh);
  EXPECT_EQ(static_cast<std::int64_t>(report.open.size()), report.loops);
}

TEST(Stitch, LoopsThatAreNotOnTheBoundaryAreRefused) {
  GapLoops loops;
  loops.add(std::vector<std::uint32_t>{0, 1, 2, 3});
  TriangleMesh mesh = ball().mesh;
  EXPECT_THROW(stitch_gaps(backend(), ball().field.view(), ball().field.sizes(1), StitchMode::exact,
                           loops, mesh),
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
      stitch_gaps(backend(), plane.view(), plane.sizes(5), StitchMode::exact, loops, mesh);
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

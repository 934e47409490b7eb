/// \file
/// The passes of remeshing, each on a small mesh by hand on a known surface.

#include "stages/patch_passes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "stages/patch_clearance.h"
#include "stages/patch_crowding.h"
#include "stages/patch_rules.h"
#include "stages/relax.h"
#include "support/analytic_field.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

constexpr float kHeight = 8;

/// Vertices (x, y) on the plane z = 8 and the triangles between them.
PatchMesh flat_patch(const std::vector<Vec3>& places, const std::vector<std::uint32_t>& corners,
                     float size, std::vector<std::uint8_t> whole = {}) {
  std::vector<SurfacePoint> points;
  for (const Vec3& p : places) points.push_back({p, {0, 0, 1}, size});
  PatchMesh patch;
  whole.resize(places.size(), 1);
  patch.build(std::move(points), corners, std::move(whole));
  return patch;
}

/// `n` triangles round vertex 0 at `centre`, their outer corners on a circle of `radius` at (8, 8).
PatchMesh wheel(int n, const Vec3& centre, float radius, float size) {
  std::vector<Vec3> places = {centre};
  std::vector<std::uint32_t> corners;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * i / n;
    places.push_back({8 + radius * static_cast<float>(std::cos(angle)),
                      8 + radius * static_cast<float>(std::sin(angle)), kHeight});
    corners.insert(corners.end(), {0, 1u + i, 1u + (i + 1) % n});
  }
  return flat_patch(places, corners, size);
}

class PatchPasses : public ::testing::Test {
 protected:
  RemeshGoal goal(float size) {
    return {field_.view(), field_.sizes(size / RemeshGoal::kLengthFactor), nullptr, false};
  }
  void smooth(PatchMesh& patch, int passes) {
    const RemeshGoal wanted = goal(1);
    Relaxer(backend(), wanted).smooth(std::array{&patch}, passes);
  }
  void equalise(PatchMesh& patch, int passes) {
    const RemeshGoal wanted = goal(1);
    Relaxer(backend(), wanted).equalise(std::array{&patch}, passes);
  }

  Backend& backend() { return *backend_; }

  AnalyticField field_ = plane_field(16, kHeight);

 private:
  std::shared_ptr<Backend> backend_ = make_tbb_backend(1, nullptr);
};

std::size_t triangles(const PatchMesh& patch) {
  std::size_t count = 0;
  for (std::uint32_t h = 0; h < patch.half_edge_end(); h += 4) count += patch.is_edge(h);
  return count;
}

TEST_F(PatchPasses, QualityIsTheLeastAngleOrHowFarATriangleTurnsAway) {
  const SurfacePoint a{{0, 0, 0}, {0, 0, 1}}, b{{1, 0, 0}, {0, 0, 1}}, c{{0, 1, 0}, {0, 0, 1}};
  EXPECT_NEAR(triangle_quality(a, b, c), 0.5f, 1e-6);  // sine of 45 degrees, squared
  EXPECT_NEAR(triangle_quality(a, c, b), -2, 1e-6);
  const SurfacePoint steep{{0, 1, 3}, {0, 0, 1}};  // 71.6 degrees
  EXPECT_NEAR(triangle_quality(a, b, steep), std::sqrt(0.1f) - 1, 1e-6);
  EXPECT_GT(triangle_quality(a, b, steep, kLeastFacingInRepair), 0);
}

TEST_F(PatchPasses, AShortEdgeGoes) {
  PatchMesh patch = wheel(6, {8.1f, 8, kHeight}, 0.6f, 1);
  collapse_short_edges(patch, kShortest, kLongest);
  EXPECT_EQ(triangles(patch), 4u);
  EXPECT_FALSE(patch.is_there(0));
}

TEST_F(PatchPasses, ACollapseThatMakesALongEdgeIsRefused) {
  PatchMesh patch = wheel(6, {8.1f, 8, kHeight}, 0.7f, 1);  // the wheel is 1.4 across
  collapse_short_edges(patch, kShortest, kLongest);
  EXPECT_EQ(triangles(patch), 6u);
}

TEST_F(PatchPasses, ACollapseThatTurnsATriangleIsRefused) {
  // The star of vertex 0 is not convex: merged into 1, the triangle (2, 3) would turn over, merged
  // into the others (4 to 6 lie behind the notch) a triangle would lie flat.
  const std::vector<Vec3> places = {{8, 8, 8},       {8.3f, 8, 8},    {8.1f, 8.1f, 8},
                                    {8.4f, 8.8f, 8}, {7.4f, 8.5f, 8}, {7.4f, 7.5f, 8},
                                    {8.3f, 7.5f, 8}};
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < 6; ++i) corners.insert(corners.end(), {0, 1 + i, 1 + (i + 1) % 6});
  PatchMesh patch = flat_patch(places, corners, 1);
  const float before = fan_quality(patch, 0, patch.points[0]);
  ASSERT_GE(before, 0);
  SurfacePoint at_one = patch.points[1];
  EXPECT_LT(triangle_quality(at_one, patch.points[2], patch.points[3]), 0);
  collapse_short_edges(patch, 0.35f, 10);  // only the edges to 1 and 2 are that short
  for (std::uint32_t h = 0; h < patch.half_edge_end(); h += 4) {
    if (!patch.is_edge(h)) continue;
    EXPECT_GE(triangle_quality(patch.points[patch.origin(h)], patch.points[patch.target(h)],
                               patch.points[patch.apex(h)]),
              0);
  }
}

TEST_F(PatchPasses, ALongEdgeIsSplitOnTheSurface) {
  PatchMesh patch =
      flat_patch({{7, 8, 7.9f}, {9, 8, 7.9f}, {8, 9, 8}, {8, 7, 8}}, {0, 1, 2, 1, 0, 3}, 1.45f);
  split_long_edges(patch, goal(1.45f), kLongest);
  ASSERT_EQ(patch.vertex_count(), 5u);
  EXPECT_EQ(triangles(patch), 4u);
  EXPECT_NEAR(patch.points[4].position.z, kHeight, 1e-3);
  EXPECT_FLOAT_EQ(patch.points[4].size, 1.45f);
  EXPECT_NEAR(patch.points[4].normal.z, 1, 1e-5);
}

TEST_F(PatchPasses, AFlipMakesTheLeastAngleLarger) {
  PatchMesh patch =
      flat_patch({{7, 8, 8}, {9, 8, 8}, {8, 8.4f, 8}, {8, 7.6f, 8}}, {0, 1, 2, 1, 0, 3}, 1);
  flip_to_angle(patch, 1);
  EXPECT_TRUE(patch.are_joined(2, 3));
  EXPECT_FALSE(patch.are_joined(0, 1));
}

TEST_F(PatchPasses, AFlipThatTurnsATriangleIsRefused) {
  // The quadrilateral has a notch at corner 1: its other diagonal lies outside.
  PatchMesh patch =
      flat_patch({{7, 8, 8}, {7.3f, 8, 8}, {8, 9, 8}, {8, 7, 8}}, {0, 1, 2, 1, 0, 3}, 1);
  flip_to_angle(patch, 1);
  flip_to_valence(patch, 1);
  EXPECT_TRUE(patch.are_joined(0, 1));
}

TEST_F(PatchPasses, SmoothingCentresAVertex) {
  PatchMesh patch = wheel(6, {8.3f, 8.2f, kHeight}, 1, 1);
  smooth(patch, 6);
  EXPECT_NEAR(patch.points[0].position.x, 8, 0.05);
  EXPECT_NEAR(patch.points[0].position.y, 8, 0.05);
  EXPECT_NEAR(patch.points[0].position.z, kHeight, 1e-3);
}

TEST_F(PatchPasses, SmoothingMovesABorderAlongItself) {
  // The middle of the lower side of a strip, off its place both along the side and across it.
  PatchMesh patch = flat_patch({{7, 8, 8}, {8.3f, 8.1f, 8}, {9, 8, 8}, {7.5f, 9, 8}, {8.5f, 9, 8}},
                               {0, 1, 3, 1, 4, 3, 1, 2, 4}, 1, {0, 1, 0, 0, 0});
  smooth(patch, 1);
  EXPECT_NEAR(patch.points[1].position.x, 8.15f, 0.01f);
  EXPECT_NEAR(patch.points[1].position.y, 8.05f, 0.01f);
}

TEST_F(PatchPasses, EqualiseRaisesTheLeastEdgeRatio) {
  PatchMesh patch = wheel(6, {8.25f, 8, kHeight}, 1, 1);
  equalise(patch, 8);
  float least = 1;
  patch.for_each_out(0, [&](std::uint32_t h) {
    const float l = norm(patch.points[patch.target(h)].position - patch.points[0].position);
    least = std::min({least, l, 1 / l});
  });
  EXPECT_GT(least, 0.81f);  // it was 0.75
}

TEST_F(PatchPasses, RepairRaisesTheLeastAngle) {
  PatchMesh patch = wheel(7, {8.85f, 8, kHeight}, 1, 1);
  ASSERT_LT(fan_quality(patch, 0, patch.points[0]), kSquaredSine20);
  EXPECT_EQ(repair(patch, goal(1), kSquaredSine25, 4), 0u);
  for (std::uint32_t h = 0; h < patch.half_edge_end(); h += 4) {
    if (!patch.is_edge(h)) continue;
    EXPECT_GE(triangle_quality(patch.points[patch.origin(h)], patch.points[patch.target(h)],
                               patch.points[patch.apex(h)]),
              kSquaredSine25);
  }
}

TEST_F(PatchPasses, AMoveIntoAnotherSheetIsRefused) {
  // A wheel, and a triangle hung over it at a height of 0.1.
  std::vector<Vec3> places = {{8, 8, 8}};
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const double angle = M_PI * i / 3;
    places.push_back(
        {8 + static_cast<float>(std::cos(angle)), 8 + static_cast<float>(std::sin(angle)), 8});
    corners.insert(corners.end(), {0, 1 + i, 1 + (i + 1) % 6});
  }
  places.insert(places.end(), {{7.5f, 7.5f, 8.1f}, {8.5f, 7.5f, 8.1f}, {8, 8.7f, 8.1f}});
  corners.insert(corners.end(), {7, 8, 9});
  PatchMesh patch = flat_patch(places, corners, 1);
  Clearance clearance(patch);
  SurfacePoint up = patch.points[0];
  up.position.z = 8.2f;
  EXPECT_FALSE(clearance.move_if_clear(patch, 0, up));
  EXPECT_EQ(patch.points[0].position.z, 8);
  up.position.z = 8.05f;
  EXPECT_TRUE(clearance.move_if_clear(patch, 0, up));
  EXPECT_EQ(patch.points[0].position.z, 8.05f);
}

TEST_F(PatchPasses, AMoveIntoAMuchLargerTriangleIsRefused) {
  // Small wheels in a row, and one triangle that hangs over all of them.
  std::vector<Vec3> places;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t wheel = 0; wheel < 12; ++wheel) {
    const Vec3 hub = {4 + 0.2f * static_cast<float>(wheel), 8, 8};
    places.push_back(hub);
    for (std::uint32_t i = 0; i < 6; ++i) {
      const double angle = M_PI * i / 3;
      places.push_back(hub + 0.05f * Vec3{static_cast<float>(std::cos(angle)),
                                          static_cast<float>(std::sin(angle)), 0});
      corners.insert(corners.end(), {7 * wheel, 7 * wheel + 1 + i, 7 * wheel + 1 + (i + 1) % 6});
    }
  }
  const auto first = static_cast<std::uint32_t>(places.size());
  places.insert(places.end(), {{0, 2, 8.1f}, {14, 2, 8.1f}, {7, 20, 8.1f}});
  corners.insert(corners.end(), {first, first + 1, first + 2});
  PatchMesh patch = flat_patch(places, corners, 1);
  Clearance clearance(patch);
  for (std::uint32_t hub = 0; hub < first; hub += 7) {
    SurfacePoint up = patch.points[hub];
    up.position.z = 8.2f;
    EXPECT_FALSE(clearance.move_if_clear(patch, hub, up)) << hub;
    up.position.z = 8.05f;
    EXPECT_TRUE(clearance.move_if_clear(patch, hub, up)) << hub;
  }
}

/// A polyhedron of equal triangles with its vertices on a sphere about (8, 8, 8).
PatchMesh ball(const TriangleMesh& mesh, float size) {
  std::vector<SurfacePoint> points;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = vertex_at(mesh, v);
    points.push_back({p + Vec3{8, 8, 8}, normalised(p), size});
  }
  PatchMesh patch;
  patch.build(std::move(points), mesh.triangles, std::vector<std::uint8_t>(mesh.vertex_count(), 1));
  return patch;
}

/// Two wheels of six triangles, the second `height` above the first and facing it.
PatchMesh facing_wheels(float height) {
  std::vector<SurfacePoint> points;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t wheel = 0; wheel < 2; ++wheel) {
    const float z = 8 + height * static_cast<float>(wheel);
    const Vec3 normal = {0, 0, wheel == 0 ? 1.0f : -1.0f};
    points.push_back({{8, 8, z}, normal, 1});
    for (std::uint32_t i = 0; i < 6; ++i) {
      const double angle = M_PI * i / 3;
      points.push_back(
          {{8 + static_cast<float>(std::cos(angle)), 8 + static_cast<float>(std::sin(angle)), z},
           normal,
           1});
      const std::uint32_t first = 7 * wheel, a = first + 1 + i, b = first + 1 + (i + 1) % 6;
      corners.insert(corners.end(), {first, wheel == 0 ? a : b, wheel == 0 ? b : a});
    }
  }
  PatchMesh patch;
  patch.build(std::move(points), corners, std::vector<std::uint8_t>(14, 1));
  return patch;
}

TEST_F(PatchPasses, VerticesAreCrowdedWhereSheetsFaceEachOther) {
  EXPECT_EQ(crowded_vertices(facing_wheels(1.1f)), std::vector<std::uint8_t>(14, 1));
  EXPECT_EQ(crowded_vertices(facing_wheels(1.3f)), std::vector<std::uint8_t>(14, 0));
}

TEST_F(PatchPasses, VerticesNearOneOffTheFieldAreCrowded) {
  PatchMesh patch = facing_wheels(1.3f);
  patch.points[7].on_field = false;
  std::vector<std::uint8_t> above(14, 1);
  std::fill_n(above.begin(), 7, 0);
  EXPECT_EQ(crowded_vertices(patch), above);
}

/// Neighbours on a small ball face elsewhere, but are of one sheet.
TEST_F(PatchPasses, VerticesAreNotCrowdedByTheirOwnFans) {
  const PatchMesh patch = ball(sphere(0.5f, 0), 1);
  EXPECT_EQ(crowded_vertices(patch), std::vector<std::uint8_t>(patch.vertex_count(), 0));
}

float least_squared_sine_in(const PatchMesh& patch) {
  float least = 1;
  for (std::uint32_t h = 0; h < patch.half_edge_end(); h += 4)
    if (patch.is_edge(h))
      least = std::min(
          least, least_squared_sine(patch.points[patch.origin(h)], patch.points[patch.target(h)],
                                    patch.points[patch.apex(h)]));
  return least;
}

TEST_F(PatchPasses, SmallAnglesGetWiderWhateverTheTrianglesFace) {
  for (const float up : {1.0f, -1.0f}) {
    PatchMesh patch = wheel(7, {8.85f, 8, kHeight}, 1, 1);
    for (SurfacePoint& point : patch.points) point.normal = {0, 0, up};
    ASSERT_LT(least_squared_sine_in(patch), kSquaredSine20);
    widen_angles(patch, 4);
    EXPECT_GE(least_squared_sine_in(patch), kSquaredSine20);
  }
}

TEST_F(PatchPasses, ATurnedEdgeMayFoldNoTriangle) {
  // Turning the edge between the first two would lay one triangle over the other.
  const std::vector<Vec3> places = {{8, 8, 8}, {10, 8, 8}, {10.4f, 8.3f, 8}, {10.4f, 7.7f, 8}};
  PatchMesh patch = flat_patch(places, {0, 1, 2, 1, 0, 3}, 1, {0, 0, 0, 0});
  ASSERT_LT(least_squared_sine_in(patch), kSquaredSine20);
  widen_angles(patch, 4);
  EXPECT_EQ(patch.origin(0), 0u);
  EXPECT_EQ(patch.target(0), 1u);
}

TEST_F(PatchPasses, AnEdgeTurnsOnlyWhereItMeetsNothing) {
  // A tent over (0, 1), and a triangle through the place of the edge (2, 3) below it.
  std::vector<Vec3> places = {{7, 8, 8.2f}, {9, 8, 8.2f}, {8, 9, 8}, {8, 7, 8}};
  std::vector<std::uint32_t> corners = {0, 1, 2, 1, 0, 3};
  PatchMesh clear = flat_patch(places, corners, 1);
  Clearance above(clear);
  EXPECT_TRUE(above.flip_if_clear(clear, 0));
  places.insert(places.end(), {{7.9f, 8, 7.5f}, {8.1f, 8, 7.5f}, {8, 8, 8.1f}});
  corners.insert(corners.end(), {4, 5, 6});
  PatchMesh blocked = flat_patch(places, corners, 1);
  Clearance clearance(blocked);
  EXPECT_FALSE(clearance.flip_if_clear(blocked, 0));
  EXPECT_EQ(blocked.target(0), 1u);
}

TEST_F(PatchPasses, FitPutsTheMiddlesOfEdgesOnTheSurface) {
  constexpr float kRadius = 2;
  AnalyticField field = sphere_field(16, {8, 8, 8}, kRadius);
  const RemeshGoal round = {field.view(), field.sizes(2), nullptr, false};
  PatchMesh patch = ball(sphere(kRadius, 0), 2);
  Relaxer relaxer(backend(), round);
  for (int times = 0; times < 3; ++times) relaxer.fit(std::array{&patch}, 0);
  // Edges of an icosahedron are seen from its centre under 63.4 degrees.
  const double expected = kRadius / std::cos(std::atan(2) / 2);
  for (std::uint32_t v = 0; v < patch.vertex_count(); ++v) {
    EXPECT_NEAR(norm(patch.points[v].position - Vec3{8, 8, 8}), expected, 0.02);
    EXPECT_FALSE(patch.points[v].on_field);
  }
}

TEST_F(PatchPasses, FitLeavesRelaxedAndStrayVertices) {
  AnalyticField field = sphere_field(16, {8, 8, 8}, 2);
  const RemeshGoal round = {field.view(), field.sizes(2), nullptr, false};
  PatchMesh patch = ball(sphere(2, 0), 2);
  patch.points[0].on_field = false;  // relaxed
  patch.points[0].drift = 0.1f;
  patch.points[3].on_field = false;  // too far out
  patch.points[3].position = Vec3{8, 8, 8} + 2.6f * patch.points[3].normal;
  const Vec3 relaxed = patch.points[0].position, stray = patch.points[3].position;
  Relaxer(backend(), round).fit(std::array{&patch}, 2);
  EXPECT_EQ(patch.points[0].position, relaxed);
  EXPECT_EQ(patch.points[3].position, stray);
}

TEST_F(PatchPasses, APointGoesOntoTheSurfaceOrStays) {
  SurfacePoint point{{8.2f, 7.7f, 8.2f}, {0, 0, 1}, 1};
  const RemeshGoal wanted = goal(1.5f);
  EXPECT_TRUE(put_onto_surface(wanted, 0.3f, point));
  EXPECT_NEAR(point.position.z, kHeight, 1e-3);
  EXPECT_FLOAT_EQ(point.size, 1.5f);
  const SurfacePoint far{{8, 8, 8.6f}, {0, 0, 1}, 1}, turned{{8, 8, 8.1f}, {0, 0, -1}, 1};
  for (SurfacePoint refused : {far, turned}) {
    const Vec3 before = refused.position;
    EXPECT_FALSE(put_onto_surface(wanted, 0.3f, refused));
    EXPECT_EQ(refused.position, before);
  }
  take_normal(wanted.field, point);
  EXPECT_TRUE(point.on_field);
  SurfacePoint off = far;
  take_normal(wanted.field, off);
  EXPECT_FALSE(off.on_field);
}

TEST_F(PatchPasses, PlacesShortenEdges) {
  const Places places(std::array<CarefulPlace, 2>{{{{8, 8, 8}, 2, 0.5f}, {{9, 8, 8}, 1, 0}}});
  RemeshGoal wanted = goal(1);
  wanted.places = &places;
  EXPECT_FLOAT_EQ(wanted.size_at({3, 3, 8}), 1);
  EXPECT_FLOAT_EQ(wanted.size_at({7, 8, 8}), 0.5f);
  EXPECT_FLOAT_EQ(wanted.size_at({9, 8, 8}), 0);
}

}  // namespace
}  // namespace vasamesh::test

/// \file
/// Hard regions: where vessels are thin or sheets close, and nowhere else; surfaces with borders.

#include "stages/hard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "stages/verify.h"
#include "support/analytic_lattice.h"
#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

Backend& backend(int threads = 2) {
  static const std::shared_ptr<Backend> backends[] = {make_tbb_backend(1, nullptr),
                                                      make_tbb_backend(2, nullptr)};
  return *backends[threads - 1];
}

std::vector<std::uint8_t> hard_regions(const AnalyticScene& scene, int threads = 2) {
  const SizeField sizes = make_sizes(backend(threads), scene.field, scene.surface, {});
  return find_hard_regions(backend(threads), scene.field, sizes, {}, scene.surface);
}

/// The part of the triangles with their first vertex in a region that is hard.
double hard_share(const AnalyticScene& scene, const std::vector<std::uint8_t>& hard,
                  const std::function<bool(const Vec3&)>& where) {
  int in = 0, found = 0;
  for (std::size_t t = 0; t < hard.size(); ++t) {
    const float* p = &scene.surface.vertices[3 * scene.surface.triangles[3 * t]];
    if (!where({p[0], p[1], p[2]})) continue;
    ++in;
    found += hard[t];
  }
  return in ? static_cast<double>(found) / in : 0;
}

TEST(Hard, NothingOfThickVessels) {
  const AnalyticScene scene(
      backend(), {40, 24, 24},
      joined({ball({12, 12, 12}, 6), capsule({12, 12, 12}, {32, 12, 12}, 2)}, 2));
  EXPECT_EQ(hard_share(scene, hard_regions(scene), [](const Vec3&) { return true; }), 0);
}

TEST(Hard, ThinVesselsButNotWhatTheyComeFrom) {
  const AnalyticScene scene(
      backend(), {48, 24, 24},
      joined({ball({12, 12, 12}, 7), capsule({12, 12, 12}, {40, 12, 12}, 0.5f)}, 1));
  const auto hard = hard_regions(scene);
  EXPECT_EQ(hard_share(scene, hard, [](const Vec3& p) { return p.x > 24; }), 1);
  EXPECT_EQ(hard_share(scene, hard, [](const Vec3& p) { return p.x < 12; }), 0);
}

TEST(Hard, SheetsThatAlmostTouch) {
  const AnalyticScene scene(backend(), {40, 24, 24},
                            joined({ball({12, 12, 12}, 6), ball({24.55f, 12, 12}, 6)}, 0.01f));
  const auto hard = hard_regions(scene);
  const auto from_gap = [](const Vec3& p) { return norm(p - Vec3{18.27f, 12, 12}); };
  EXPECT_EQ(hard_share(scene, hard, [&](const Vec3& p) { return from_gap(p) < 2; }), 1);
  EXPECT_EQ(hard_share(scene, hard, [&](const Vec3& p) { return from_gap(p) > 9; }), 0);
}

/// A ball with bumps, whose tops are hard here and there.
Solid3 bumpy_ball(float shift) {
  return [shift](const Vec3& p) {
    const float bump = std::sin(1.9f * p.x + shift) * std::sin(2.1f * p.y) * std::sin(2 * p.z);
    return ball({16, 16, 16}, 11)(p) + 0.5f * bump;
  };
}

TEST(Hard, RegionsAreSurfacesWithBordersAtAnyNumberOfThreads) {
  for (const float shift : {0.0f, 0.3f, 0.6f, 0.9f}) {
    const AnalyticScene scene(backend(), {32, 32, 32}, bumpy_ball(shift));
    const auto hard = hard_regions(scene);
    EXPECT_EQ(hard, hard_regions(scene, 1));
    TriangleMesh region;
    region.vertices = scene.surface.vertices;
    for (std::size_t t = 0; t < hard.size(); ++t)
      if (hard[t])
        region.triangles.insert(region.triangles.end(), &scene.surface.triangles[3 * t],
                                &scene.surface.triangles[3 * t] + 3);
    const CheckReport report = check_surface(backend(), region, nullptr);
    EXPECT_GT(report.open_edges, 100);
    EXPECT_EQ(report.nonmanifold_vertices, 0);
  }
}

std::size_t count(const std::vector<std::uint8_t>& bytes) {
  return static_cast<std::size_t>(
      std::count_if(bytes.begin(), bytes.end(), [](auto byte) { return byte != 0; }));
}

TEST(Chosen, TheTrianglesAtAFlaggedVertexAlone) {
  const TriangleMesh mesh = torus(9, 3, 24, 12);
  std::vector<std::uint8_t> none(mesh.vertex_count());
  EXPECT_EQ(count(choose_triangles(backend(), mesh, none)), 0u);
  std::vector<std::uint8_t> flagged(mesh.vertex_count());
  flagged[40] = 1;
  const std::vector<std::uint8_t> chosen = choose_triangles(backend(), mesh, flagged);
  EXPECT_EQ(count(chosen), 6u);
  EXPECT_EQ(count(flagged), 1u);
  for (std::size_t t = 0; t < chosen.size(); ++t) {
    const auto* corners = &mesh.triangles[3 * t];
    EXPECT_EQ(chosen[t], std::find(corners, corners + 3, 40u) != corners + 3) << t;
  }
}

TEST(Chosen, MoreUntilEachVertexHasOneFan) {
  const TriangleMesh mesh = torus(9, 3, 40, 24);
  std::mt19937 random(11);
  bool more = false;
  for (const unsigned one_in : {3u, 6u, 12u}) {
    std::vector<std::uint8_t> given(mesh.vertex_count());
    for (std::uint8_t& flag : given) flag = random() % one_in == 0;
    std::vector<std::uint8_t> flagged = given;
    const std::vector<std::uint8_t> chosen = choose_triangles(backend(), mesh, flagged);
    TriangleMesh region;
    region.vertices = mesh.vertices;
    for (std::size_t t = 0; t < chosen.size(); ++t) {
      const auto* v = &mesh.triangles[3 * t];
      EXPECT_EQ(chosen[t], flagged[v[0]] || flagged[v[1]] || flagged[v[2]]) << t;
      if (chosen[t]) region.triangles.insert(region.triangles.end(), v, v + 3);
    }
    for (std::size_t v = 0; v < given.size(); ++v) EXPECT_TRUE(flagged[v] || !given[v]) << v;
    EXPECT_EQ(check_surface(backend(), region, nullptr).nonmanifold_vertices, 0);
    more |= count(flagged) > count(given);
  }
  EXPECT_TRUE(more);
}

}  // namespace
}  // namespace vasamesh::test

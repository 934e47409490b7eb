/// \file
/// Mesh expanding on known surfaces: what the front leaves is a surface with borders on the zero
/// set, of good triangles, that stitching closes with the right topology.

#include "stages/expand.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "stages/quality.h"
#include "stages/stitch.h"
#include "stages/verify.h"
#include "support/analytic_lattice.h"
#include "support/backends.h"
#include "support/invariants.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

Backend& backend(int threads = 2) {
  static const std::shared_ptr<Backend> backends[] = {
      make_tbb_backend(1, nullptr), make_tbb_backend(2, nullptr), make_tbb_backend(4, nullptr)};
  return *backends[threads / 2];
}

/// A surface with its sizes.
struct Scene {
  Scene(const std::array<int, 3>& size, const Solid3& solid, const SizeRule& rule = {},
        const Scale& scale = {1, 1, 1})
      : base(backend(), size, solid, scale),
        sizes(make_sizes(backend(), base.field, base.surface, rule)) {}

  FrontResult expand(const TriangleMesh& patches = {}, int threads = 2) const {
    return expand(backend(threads), patches);
  }
  FrontResult expand(Backend& on, const TriangleMesh& patches) const {
    return vasamesh::expand(on, base.field, sizes, patches);
  }
  StitchReport stitch(FrontResult& front) const {
    return stitch_gaps(backend(), base.field.view(), sizes.view(base.field), StitchMode::exact,
                       front.loops, front.mesh);
  }

  AnalyticScene base;
  SizeField sizes;
};

const Scene& sphere_scene() {
  static const Scene scene({24, 24, 24}, ball({12, 12, 12}, 8));
  return scene;
}

const Scene& torus_scene() {
  static const Scene scene({36, 36, 16}, ring({18, 18, 8}, 11, 3.5f));
  return scene;
}

std::set<Edge> edges_of(const TriangleMesh& mesh) {
  std::set<Edge> edges;
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    EXPECT_TRUE(edges.emplace(mesh.triangles[c], mesh.triangles[c / 3 * 3 + (c + 1) % 3]).second);
  return edges;
}

/// The loops run along the boundary, each of its edges once, with the gap to their left.
void expect_loops_are_the_boundary(const FrontResult& front) {
  const std::set<Edge> edges = edges_of(front.mesh);
  std::set<Edge> open, loops;
  for (const auto& [from, to] : edges)
    if (!edges.contains({to, from})) open.emplace(to, from);
  for (std::size_t i = 0; i < front.loops.count(); ++i) {
    const auto loop = front.loops[i];
    for (std::size_t k = 0; k < loop.size(); ++k)
      EXPECT_TRUE(loops.emplace(loop[k], loop[(k + 1) % loop.size()]).second);
  }
  EXPECT_EQ(open, loops);
}

/// On the zero set, facing outwards, without edges of three triangles or crossings.
void expect_front_is_sound(const Scene& scene, const FrontResult& front, float tolerance = 0.02f) {
  expect_loops_are_the_boundary(front);
  const FieldView field = scene.base.field.view();
  for (std::uint32_t v = 0; v < front.mesh.vertex_count(); ++v) {
    const FieldSample at = sample_field(field, vertex_at(front.mesh, v));
    ASSERT_TRUE(at.known);
    ASSERT_LT(std::fabs(at.value), tolerance * norm(at.gradient)) << v;
  }
  for (std::size_t t = 0; t < front.mesh.triangle_count(); ++t) {
    const std::uint32_t* v = &front.mesh.triangles[3 * t];
    const Vec3 a = vertex_at(front.mesh, v[0]);
    const Vec3 n = cross(vertex_at(front.mesh, v[1]) - a, vertex_at(front.mesh, v[2]) - a);
    for (std::size_t i = 0; i < 3; ++i)
      ASSERT_LT(dot(n, sample_field(field, vertex_at(front.mesh, v[i])).gradient), 0) << t;
  }
  EXPECT_EQ(check_surface(backend(), front.mesh, nullptr).intersecting_pairs, 0);
}

double good_share(const TriangleMesh& mesh) {
  std::size_t good = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    float edge[3];
    for (std::size_t i = 0; i < 3; ++i)
      edge[i] = norm(vertex_at(mesh, mesh.triangles[3 * t + i]) -
                     vertex_at(mesh, mesh.triangles[3 * t + (i + 1) % 3]));
    const auto [least, most] = std::minmax_element(edge, edge + 3);
    good += *least >= 0.8f * *most;
  }
  return static_cast<double>(good) / static_cast<double>(mesh.triangle_count());
}

double open_share(const FrontResult& front) {
  return static_cast<double>(front.loops.vertex.size()) /
         static_cast<double>(front.mesh.triangle_count());
}

TEST(Expand, Sphere) {
  FrontResult front = sphere_scene().expand();
  expect_front_is_sound(sphere_scene(), front);
  EXPECT_FALSE(front.over_budget);
  EXPECT_LT(open_share(front), 0.03);
  EXPECT_GT(good_share(front.mesh), 0.75);
  EXPECT_NEAR(static_cast<double>(front.mesh.triangle_count()),
              sphere_scene().sizes.predicted_triangles,
              0.15 * sphere_scene().sizes.predicted_triangles);
  EXPECT_TRUE(sphere_scene().stitch(front).open.empty());
  expect_good_surface(front.mesh, Topology{1, 0, 0});
}

TEST(Expand, TorusClosesByJoins) {
  FrontResult front = torus_scene().expand();
  expect_front_is_sound(torus_scene(), front);
  EXPECT_LT(open_share(front), 0.03);
  EXPECT_GT(good_share(front.mesh), 0.75);
  EXPECT_TRUE(torus_scene().stitch(front).open.empty());
  expect_good_surface(front.mesh, Topology{1, 1, 0});
}

TEST(Expand, ThickRandomTrees) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    SCOPED_TRACE(seed);
    const Scene scene({48, 48, 48}, random_tree(seed, 5, 48));
    FrontResult front = scene.expand();
    expect_front_is_sound(scene, front);
    EXPECT_LT(open_share(front), 0.03);
    EXPECT_GT(good_share(front.mesh), 0.75);
  }
}

TEST(Expand, VoxelsNeedNotBeCubes) {
  const Scene scene({40, 40, 20}, capsule({8, 9, 10}, {24, 22, 18}, 4), {}, {0.8f, 0.8f, 1.5625f});
  FrontResult front = scene.expand();
  expect_front_is_sound(scene, front);
  EXPECT_TRUE(scene.stitch(front).open.empty());
  expect_good_surface(front.mesh, Topology{1, 0, 0});
}

TEST(Expand, EveryComponentGetsItsSeeds) {
  std::vector<Solid3> balls;
  for (int i = 0; i < 27; ++i)
    balls.push_back(
        ball({6 + 7.0f * static_cast<float>(i % 3), 6 + 7.0f * static_cast<float>(i / 3 % 3),
              6 + 7.0f * static_cast<float>(i / 9)},
             2.2f));
  const Scene scene({28, 28, 28}, joined(balls, 0.1f));
  FrontResult front = scene.expand();
  expect_front_is_sound(scene, front);
  EXPECT_TRUE(scene.stitch(front).open.empty());
  expect_good_surface(front.mesh, Topology{27, 0, 0});
}

/// Edges are as long as is asked for along a vessel that widens.
TEST(Expand, EdgesFollowTheSizes) {
  std::vector<Solid3> balls;
  for (int i = 0; i <= 120; ++i) {
    const auto t = static_cast<float>(i);
    balls.push_back(ball({9 + 0.35f * t, 12, 12}, 1.7f + 0.045f * t));
  }
  const Scene scene({64, 24, 24}, joined(balls, 0.2f), {.edge_min = 0.5f, .edge_max = 4});
  const FrontResult front = scene.expand();
  expect_front_is_sound(scene, front);
  const SizeView sizes = scene.sizes.view(scene.base.field);
  std::map<int, std::array<double, 2>> by_place;  // sums of edge over size, and counts
  for (const auto& [from, to] : edges_of(front.mesh)) {
    const Vec3 a = vertex_at(front.mesh, from), b = vertex_at(front.mesh, to);
    auto& sums = by_place[static_cast<int>(a.x) / 8];
    sums[0] += norm(b - a) / (0.5f * (size_at(sizes, a) + size_at(sizes, b)));
    sums[1] += 1;
  }
  EXPECT_GT(by_place.size(), 5u);
  for (const auto& [place, sums] : by_place) EXPECT_NEAR(sums[0] / sums[1], 1, 0.15) << place;
}

TEST(Expand, SameForAnyNumberOfThreadsAndInEveryRepeat) {
  // Four workers even where there are fewer cores.
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const Scene scene({48, 48, 48}, random_tree(7, 6, 48));
  const FrontResult first = scene.expand({}, 1);
  for (const int threads : {1, 2, 4}) {
    const FrontResult again = scene.expand({}, threads);
    EXPECT_EQ(first.mesh.vertices, again.mesh.vertices);
    EXPECT_EQ(first.mesh.triangles, again.mesh.triangles);
    EXPECT_EQ(first.loops.vertex, again.loops.vertex);
  }
}

TEST(Expand, SameOnEveryBackend) {
  const Scene scene({48, 48, 48}, random_tree(7, 6, 48));
  const FrontResult want = scene.expand();
  for (const std::string& name : backend_names()) {
    const std::shared_ptr<Backend> on = open_backend(name);
    if (!on) continue;
    SCOPED_TRACE(name);
    const FrontResult got = scene.expand(*on, {});
    EXPECT_EQ(got.mesh.vertices, want.mesh.vertices);
    EXPECT_EQ(got.mesh.triangles, want.mesh.triangles);
    EXPECT_EQ(got.loops.vertex, want.loops.vertex);
    EXPECT_EQ(got.rounds, want.rounds);
  }
}

/// The triangles of a mesh with all vertices where `keep` says, and their vertices alone.
TriangleMesh cut(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& keep) {
  TriangleMesh part;
  std::map<std::uint32_t, std::uint32_t> places;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::uint32_t* v = &mesh.triangles[3 * t];
    if (!std::all_of(v, v + 3, [&](std::uint32_t i) { return keep(vertex_at(mesh, i)); })) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [entry, is_new] =
          places.try_emplace(v[i], static_cast<std::uint32_t>(part.vertex_count()));
      if (is_new)
        part.vertices.insert(part.vertices.end(), &mesh.vertices[3 * v[i]],
                             &mesh.vertices[3 * v[i]] + 3);
      part.triangles.push_back(entry->second);
    }
  }
  return part;
}

TEST(Expand, GrowsFromPatchesAndLeavesThemAsTheyAre) {
  const TriangleMesh whole = sphere_scene().expand().mesh;
  for (const auto& keep : {std::function<bool(const Vec3&)>([](const Vec3& p) { return p.z < 10; }),
                           std::function<bool(const Vec3&)>([](const Vec3& p) {
                             return (static_cast<int>(p.x) / 5 + static_cast<int>(p.y) / 5) % 2 ==
                                    0;
                           })}) {
    const TriangleMesh patches = cut(whole, keep);
    ASSERT_GT(patches.triangle_count(), 100u);
    FrontResult front = sphere_scene().expand(patches);
    expect_front_is_sound(sphere_scene(), front);
    EXPECT_TRUE(
        std::equal(patches.vertices.begin(), patches.vertices.end(), front.mesh.vertices.begin()));
    EXPECT_TRUE(std::equal(patches.triangles.begin(), patches.triangles.end(),
                           front.mesh.triangles.begin()));
    EXPECT_LT(open_share(front), 0.06);
    EXPECT_TRUE(sphere_scene().stitch(front).open.empty());
    expect_good_surface(front.mesh, Topology{1, 0, 0});
  }
}

TEST(Expand, AClosedPatchIsLeftAlone) {
  FrontResult front = sphere_scene().expand();
  ASSERT_TRUE(sphere_scene().stitch(front).open.empty());
  const FrontResult again = sphere_scene().expand(front.mesh);
  EXPECT_EQ(again.mesh.vertices, front.mesh.vertices);
  EXPECT_EQ(again.mesh.triangles, front.mesh.triangles);
  EXPECT_EQ(again.loops.count(), 0u);
}

TEST(Expand, StopsAtThreeTimesThePrediction) {
  Scene scene({24, 24, 24}, ball({12, 12, 12}, 8), {.edge_min = 0.4f, .edge_max = 0.4f});
  ASSERT_GT(scene.sizes.predicted_triangles, 8000);
  scene.sizes.predicted_triangles = 1500;
  const FrontResult front = scene.expand();
  EXPECT_TRUE(front.over_budget);
  EXPECT_GT(front.mesh.triangle_count(), 4500u);
  EXPECT_LT(front.mesh.triangle_count(), 8000u);
  expect_front_is_sound(scene, front);
}

TEST(Expand, NothingFromNothing) {
  const Scene scene({16, 16, 16}, [](const Vec3&) { return -1.0f; });
  const FrontResult front = scene.expand();
  EXPECT_EQ(front.mesh.triangle_count(), 0u);
  EXPECT_EQ(front.loops.count(), 0u);
}

}  // namespace
}  // namespace vasamesh::test

/// \file
/// Remeshing of base surfaces: topology, least angle, edge lengths and number of triangles on known
/// and on random shapes; patches with borders; places that are remeshed with more care.

#include "stages/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "stages/intersect.h"
#include "stages/quality.h"
#include "stages/sizing.h"
#include "support/analytic_lattice.h"
#include "support/invariants.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

Backend& backend() {
  static const std::shared_ptr<Backend> tbb = make_tbb_backend(2, nullptr);
  return *tbb;
}

struct Scene {
  Scene(const std::array<int, 3>& size, const Solid3& solid, const SizeRule& rule = {},
        const Scale& scale = {1, 1, 1})
      : base(backend(), size, solid, scale),
        sizes(make_sizes(backend(), base.field, base.surface, rule)) {}

  TriangleMesh remeshed(Backend& on = backend(), std::span<const CarefulPlace> places = {}) const {
    return remesh(on, base.field.view(), sizes.view(base.field), base.surface, places);
  }

  AnalyticScene base;
  SizeField sizes;
};

/// The topology of the base surface, no intersection, no small angle, mostly even triangles.
void expect_good_remesh(const Scene& scene, const TriangleMesh& mesh) {
  const CheckReport base = check(scene.base.surface);
  ASSERT_TRUE(base.passed) << base.reason;
  expect_good_surface(mesh, base.topology);
  std::vector<std::int64_t> genus = check(mesh).shell_genus, wanted = base.shell_genus;
  std::sort(genus.begin(), genus.end());
  std::sort(wanted.begin(), wanted.end());
  EXPECT_EQ(genus, wanted);
  const QualityReport quality = measure_quality(backend(), mesh);
  EXPECT_GE(quality.least_angle.minimum, 20);
  EXPECT_EQ(quality.edge_ratio_below_03, 0);
}

TEST(Remesh, ABallGetsEvenTrianglesOnItsSurface) {
  const Scene scene({32, 32, 32}, ball({16, 16, 16}, 9));
  const TriangleMesh mesh = scene.remeshed();
  expect_good_remesh(scene, mesh);
  const QualityReport quality = measure_quality(backend(), mesh);
  EXPECT_GE(quality.edge_ratio_above_08, 0.8);
  EXPECT_GE(quality.least_angle.percentile_5, 44);
  EXPECT_NEAR(static_cast<double>(mesh.triangle_count()) / scene.sizes.predicted_triangles, 1, 0.1);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_NEAR(norm(vertex_at(mesh, v) - Vec3{16, 16, 16}), 9, 0.25);
  EXPECT_NEAR(quality.volume, 4 * M_PI / 3 * 9 * 9 * 9, 15);  // half a percent
}

TEST(Remesh, ARingKeepsItsHandle) {
  const Scene scene({36, 36, 16}, ring({18, 18, 8}, 11, 3.5f));
  expect_good_remesh(scene, scene.remeshed());
}

TEST(Remesh, AThinRingTakesNoMoreTrianglesThanItsSizesAskFor) {
  for (const float radius : {0.6f, 0.7f, 0.8f}) {
    SCOPED_TRACE(radius);
    const Scene scene({36, 36, 16}, ring({18, 18, 8}, 11, radius));
    const TriangleMesh mesh = scene.remeshed();
    expect_good_remesh(scene, mesh);
    EXPECT_NEAR(static_cast<double>(mesh.triangle_count()) / scene.sizes.predicted_triangles, 1,
                0.14);
  }
}

TEST(Remesh, EdgesFollowTheRadiusOfATaperedTube) {
  // From radius 1.5 to 5 along 40 lengths: h from about 0.9 to 3.
  SizeRule rule;
  rule.edge_min = 0.5f;
  rule.edge_max = 5;
  const auto radius_at = [](float x) { return 1.5f + 3.5f * (x - 8) / 40; };
  const Scene scene(
      {56, 24, 24},
      [&](const Vec3& p) {
        const float across = norm(Vec3{0, p.y - 12, p.z - 12});
        return std::min({radius_at(p.x) - across, p.x - 8, 48 - p.x});
      },
      rule);
  const TriangleMesh mesh = scene.remeshed();
  expect_good_surface(mesh, Topology{1, 0, 0});
  for (const float x : {18.0f, 28.0f, 38.0f}) {
    double sum = 0;
    int count = 0;
    for (std::size_t c = 0; c < mesh.triangles.size(); ++c) {
      const Vec3 a = vertex_at(mesh, mesh.triangles[c]),
                 b = vertex_at(mesh, mesh.triangles[c / 3 * 3 + (c + 1) % 3]);
      if (std::abs(0.5f * (a.x + b.x) - x) > 2) continue;
      sum += norm(b - a);
      ++count;
    }
    ASSERT_GT(count, 20);
    EXPECT_NEAR(sum / count / (rule.rho * radius_at(x)), 1, 0.25) << "at " << x;
  }
}

TEST(Remesh, RandomTreesKeepTheirTopology) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Scene scene({40, 40, 40}, random_tree(seed, 5, 40));
    const TriangleMesh mesh = scene.remeshed();
    expect_good_remesh(scene, mesh);
    EXPECT_GE(measure_quality(backend(), mesh).edge_ratio_above_08, 0.75) << "seed " << seed;
  }
}

TEST(Remesh, ThinAndCloseSheets) {
  // A needle of radius 0.4, and two plates with a slit of one length between them.
  const Scene needle({16, 16, 40}, capsule({8, 8, 6}, {8.6f, 7.3f, 34}, 0.4f));
  expect_good_remesh(needle, needle.remeshed());
  const auto plate = [](float low) {
    return [=](const Vec3& p) {
      const float side = std::min({p.x - 5, 19 - p.x, p.y - 5, 19 - p.y});
      return std::min(side, 1 - std::abs(p.z - low));
    };
  };
  const Scene slit({24, 24, 16},
                   [&](const Vec3& p) { return std::max(plate(6.5f)(p), plate(9.5f)(p)); });
  expect_good_remesh(slit, slit.remeshed());
}

TEST(Remesh, AnisotropicVoxels) {
  const Scene scene({32, 32, 16}, ball({10, 10, 10}, 6), {}, {0.63f, 0.63f, 2.52f});
  expect_good_surface(scene.remeshed(), Topology{1, 0, 0});
}

TEST(Remesh, AVoxelStaysASurface) {
  const Scene scene({8, 8, 8}, ball({4, 4, 4}, 0.5f));
  const TriangleMesh mesh = scene.remeshed();
  expect_good_surface(mesh, Topology{1, 0, 0});
  EXPECT_GE(mesh.triangle_count(), 8u);
}

TEST(Remesh, TheSameBytesOnAnyNumberOfThreads) {
  const Scene scene({40, 40, 40}, random_tree(3, 6, 40));
  const TriangleMesh one = scene.remeshed(*make_tbb_backend(1, nullptr));
  for (int threads : {2, 4}) {
    const TriangleMesh other = scene.remeshed(*make_tbb_backend(threads, nullptr));
    EXPECT_EQ(one.vertices, other.vertices);
    EXPECT_EQ(one.triangles, other.triangles);
  }
}

/// Border edges and the loops that they form.
struct Borders {
  std::size_t edges = 0, loops = 0;
};

Borders borders_of(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    ++edges[{mesh.triangles[c], mesh.triangles[c / 3 * 3 + (c + 1) % 3]}];
  std::map<std::uint32_t, std::uint32_t> next;
  for (const auto& [edge, count] : edges)
    if (!edges.contains({edge.second, edge.first})) next[edge.first] = edge.second;
  Borders borders{next.size(), 0};
  while (!next.empty()) {
    ++borders.loops;
    for (auto at = next.begin(); at != next.end();) {
      const std::uint32_t v = at->second;
      next.erase(at);
      at = next.find(v);
    }
  }
  return borders;
}

/// A band of a tube along x, open at both ends.
TriangleMesh band_of(const TriangleMesh& tube) {
  TriangleMesh band;
  band.vertices = tube.vertices;
  for (std::size_t c = 0; c < tube.triangles.size(); c += 3) {
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
      const Vec3 p = vertex_at(band, tube.triangles[c + i]);
      inside = inside && p.x > 12 && p.x < 28;
    }
    if (!inside) continue;
    const auto first = tube.triangles.begin() + static_cast<std::ptrdiff_t>(c);
    band.triangles.insert(band.triangles.end(), first, first + 3);
  }
  return band;
}

TEST(Remesh, APatchKeepsItsBorders) {
  const Scene scene({40, 16, 16}, capsule({6, 8, 8}, {34, 8, 8}, 3));
  const TriangleMesh band = band_of(scene.base.surface);
  ASSERT_EQ(borders_of(band).loops, 2u);
  const TriangleMesh mesh =
      remesh(backend(), scene.base.field.view(), scene.sizes.view(scene.base.field), band);
  const Borders borders = borders_of(mesh);
  EXPECT_EQ(borders.loops, 2u);
  EXPECT_GE(borders.edges, 2u * 6);
  EXPECT_LT(borders.edges, 60u);
  const CheckReport report = check(mesh);
  EXPECT_EQ(report.open_edges, static_cast<std::int64_t>(borders.edges));
  EXPECT_EQ(report.nonmanifold_edges + report.misoriented_edges + report.nonmanifold_vertices, 0);
  EXPECT_EQ(report.intersecting_pairs, 0);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = vertex_at(mesh, v);
    EXPECT_NEAR(norm(Vec3{0, p.y - 8, p.z - 8}), 3, 0.25)
        << "vertex " << v << " at " << p.x << " " << p.y << " " << p.z;
    EXPECT_GT(p.x, 11.5f);
    EXPECT_LT(p.x, 28.5f);
  }
}

TEST(Remesh, PlacesAtABorderLeaveItAsItIs) {
  const Scene scene({40, 16, 16}, capsule({6, 8, 8}, {34, 8, 8}, 3));
  const TriangleMesh band = band_of(scene.remeshed());
  const CarefulPlace place = {{13, 8, 11}, 4, 0.5f};
  const TriangleMesh mesh = remesh_places(backend(), scene.base.field.view(),
                                          scene.sizes.view(scene.base.field), band, {&place, 1});
  EXPECT_GT(mesh.triangle_count(), band.triangle_count());
  const auto rim_of = [](const TriangleMesh& open) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t c = 0; c < open.triangles.size(); ++c) {
      const std::uint32_t v = open.triangles[c], w = open.triangles[c % 3 == 2 ? c - 2 : c + 1];
      ++edges[{std::min(v, w), std::max(v, w)}];
    }
    std::set<std::array<float, 6>> rim;  // ends of edges with one triangle
    for (const auto& [edge, count] : edges) {
      if (count != 1) continue;
      Vec3 a = vertex_at(open, edge.first), b = vertex_at(open, edge.second);
      if (std::tie(b.x, b.y, b.z) < std::tie(a.x, a.y, a.z)) std::swap(a, b);
      rim.insert({a.x, a.y, a.z, b.x, b.y, b.z});
    }
    return rim;
  };
  EXPECT_EQ(rim_of(mesh), rim_of(band));
}

TEST(Remesh, PlacesKeepTheInputOrGetShorterEdges) {
  const Scene scene({36, 36, 16}, ring({18, 18, 8}, 11, 3.5f));
  const Vec3 kept = {29, 18, 8}, finer = {3.5f, 18, 8};
  const CarefulPlace places[] = {{kept, 4, 0}, {finer, 4, 0.5f}};
  const TriangleMesh mesh = scene.remeshed(backend(), places);
  const CheckReport report = check(mesh);
  EXPECT_TRUE(report.passed) << report.reason;
  EXPECT_EQ(report.topology, (Topology{1, 1, 0}));

  std::map<std::array<float, 3>, int> base;
  std::size_t inside = 0, there = 0, near_finer = 0, near_finer_before = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = vertex_at(mesh, v);
    ++base[{p.x, p.y, p.z}];
    near_finer += norm(p - finer) < 3.5f;
  }
  for (std::uint32_t v = 0; v < scene.base.surface.vertex_count(); ++v) {
    const Vec3 p = vertex_at(scene.base.surface, v);
    if (norm(p - kept) >= 4) continue;
    ++inside;
    there += base.contains({p.x, p.y, p.z});
  }
  EXPECT_EQ(there, inside);
  const TriangleMesh plain = scene.remeshed();
  for (std::uint32_t v = 0; v < plain.vertex_count(); ++v)
    near_finer_before += norm(vertex_at(plain, v) - finer) < 3.5f;
  EXPECT_GT(near_finer, 2 * near_finer_before);
}

TEST(Remesh, ThinTreesDoNotMeetThemselves) {
  const Scene scene({40, 40, 40}, random_tree(2, 5, 40));
  const TriangleMesh mesh = scene.remeshed();
  EXPECT_EQ(find_intersections(backend(), mesh, build_triangle_tree(backend(), mesh)).count, 0);
}

TEST(Remesh, PlacesCoverThePairs) {
  TriangleMesh mesh;
  for (float x : {0.0f, 0.5f, 20.0f})
    for (int i = 0; i < 3; ++i)
      mesh.vertices.insert(mesh.vertices.end(), {x, static_cast<float>(i), 0});
  mesh.triangles = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<TrianglePair> pairs = {{0, 1}, {1, 1}, {2, 2}};
  const std::vector<CarefulPlace> places = places_at(centres_of(mesh, pairs), 2, 0.5f);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_NEAR(places[0].centre.x, 0.25f, 1e-5);
  EXPECT_NEAR(places[1].centre.x, 20, 1e-4);
  EXPECT_EQ(places[1].radius, 2);
  EXPECT_EQ(places[1].factor, 0.5f);
}

TEST(Remesh, NothingStaysNothing) {
  const Scene scene({8, 8, 8}, ball({4, 4, 4}, 2));
  EXPECT_EQ(remesh(backend(), scene.base.field.view(), scene.sizes.view(scene.base.field), {})
                .triangle_count(),
            0u);
}

}  // namespace
}  // namespace vasamesh::test

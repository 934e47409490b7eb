/// \file
/// Self-intersections against exact constructions of CGAL, pair by pair, and against CGAL's own
/// search; on random triangles full of coincidences, near-coincidences, and on real shapes.

#include "stages/intersect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reference/exact_intersections.h"
#include "stages/predicates.h"
#include "support/backends.h"
#include "support/broken_meshes.h"
#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {

void PrintTo(const TrianglePair& pair, std::ostream* out) {
  *out << pair.first << "-" << pair.second;
}

namespace {

/// Of the triangles that are not degenerate.
TriangleTree tree_of(const TriangleMesh& mesh) {
  const auto host = make_tbb_backend(2, nullptr);
  std::vector<std::uint8_t> keep(mesh.triangle_count());
  for (std::uint32_t t = 0; t < keep.size(); ++t) keep[t] = !is_degenerate(mesh, t);
  return build_triangle_tree(*host, mesh, keep);
}

/// All that there are here.
const std::vector<std::shared_ptr<Backend>>& backends() {
  static const std::vector<std::shared_ptr<Backend>> opened = [] {
    std::vector<std::shared_ptr<Backend>> some;
    for (const std::string& name : backend_names())
      if (auto backend = open_backend(name)) some.push_back(std::move(backend));
    return some;
  }();
  return opened;
}

/// The same on every backend.
Intersections find(const TriangleMesh& mesh) {
  const TriangleTree tree = tree_of(mesh);
  const Intersections found = find_intersections(*backends()[0], mesh, tree);
  const std::vector<TrianglePair> candidates = candidate_pairs(*backends()[0], mesh, tree);
  for (const auto& backend : backends()) {
    const Intersections again = find_intersections(*backend, mesh, tree);
    EXPECT_EQ(again.count, found.count) << backend->name();
    EXPECT_EQ(again.pairs, found.pairs) << backend->name();
    EXPECT_EQ(candidate_pairs(*backend, mesh, tree), candidates) << backend->name();
  }
  return found;
}

/// Triangles between random vertices of a mesh that has none yet.
TriangleMesh random_triangles(TriangleMesh mesh, int triangles, std::mt19937& random) {
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  while (static_cast<int>(mesh.triangle_count()) < triangles) {
    const std::uint32_t a = random() % count, b = random() % count, c = random() % count;
    if (a != b && b != c && c != a) add_triangle(mesh, a, b, c);
  }
  return mesh;
}

void expect_exact(const TriangleMesh& mesh) {
  const std::vector<TrianglePair> wanted = all_exact_intersections(mesh);
  const Intersections found = find(mesh);
  EXPECT_EQ(found.count, static_cast<std::int64_t>(wanted.size()));
  EXPECT_EQ(found.pairs, wanted);
}

/// Vertices on a small grid: coincident ones, coplanar and collinear ones, touching of all kinds.
TEST(Intersect, RandomTrianglesOnAGrid) {
  std::mt19937 random(11);
  for (int round = 0; round < 60; ++round) {
    TriangleMesh mesh;
    const unsigned side = 2 + random() % 4;
    for (int v = 0; v < 14; ++v)
      add_vertex(mesh, {static_cast<float>(random() % side), static_cast<float>(random() % side),
                        static_cast<float>(random() % (round % 3 ? side : 1))});
    SCOPED_TRACE(round);
    expect_exact(random_triangles(mesh, 18, random));
  }
}

/// The same on a skew grid of large integers: as many coincidences, and doubles cannot hold the
/// determinants that tell them.
TEST(Intersect, RandomTrianglesOnASkewGrid) {
  std::mt19937 random(15);
  for (int round = 0; round < 60; ++round) {
    int axis[3][3];
    for (auto& vector : axis)
      for (int& x : vector) x = static_cast<int>(random() % 1000001) - 500000;
    TriangleMesh mesh;
    for (int v = 0; v < 14; ++v) {
      const int step[3] = {static_cast<int>(random() % 5), static_cast<int>(random() % 5),
                           static_cast<int>(random() % (round % 2 ? 2 : 5))};
      Vertex p{};
      for (int a = 0; a < 3; ++a)
        p[a] =
            static_cast<float>(step[0] * axis[0][a] + step[1] * axis[1][a] + step[2] * axis[2][a]);
      add_vertex(mesh, p);
    }
    SCOPED_TRACE(round);
    expect_exact(random_triangles(mesh, 18, random));
  }
}

/// Vertices rounded onto a common slanted plane, far from the origin: nothing that doubles decide.
TEST(Intersect, NearlyCoplanarTriangles) {
  std::mt19937 random(12);
  const auto coordinate = [&] { return static_cast<float>(random() % 1000) * 0.013f; };
  for (int round = 0; round < 12; ++round) {
    TriangleMesh mesh;
    for (int v = 0; v < 14; ++v) {
      const float s = coordinate(), t = coordinate();
      add_vertex(mesh, {100 + s, -700 + t, 1500 + 0.37f * s - 0.61f * t});
    }
    SCOPED_TRACE(round);
    expect_exact(random_triangles(mesh, 16, random));
  }
}

/// Sizes from 1e-7 to 1e7 in one mesh.
TEST(Intersect, WildSizes) {
  std::mt19937 random(13);
  for (int round = 0; round < 12; ++round) {
    TriangleMesh mesh;
    for (int v = 0; v < 14; ++v) {
      const auto wild = [&] {
        return (static_cast<float>(random() % 7) - 3) *
               std::pow(10.0f, static_cast<float>(random() % 14) - 7);
      };
      add_vertex(mesh, {wild(), wild(), wild()});
    }
    SCOPED_TRACE(round);
    expect_exact(random_triangles(mesh, 16, random));
  }
}

TEST(Intersect, EachKindOfBrokenMesh) {
  for (const NamedMesh& broken : self_intersecting_meshes()) {
    SCOPED_TRACE(broken.name);
    const std::vector<TrianglePair> wanted = all_exact_intersections(broken.mesh);
    EXPECT_FALSE(wanted.empty());
    EXPECT_EQ(find(broken.mesh).pairs, wanted);
  }
}

TEST(Intersect, CleanShapesHaveNone) {
  EXPECT_EQ(find(box({0, 0, 0}, {1, 1, 1})).count, 0);
  EXPECT_EQ(find(sphere(2, 4)).count, 0);
  EXPECT_EQ(find(torus(5, 2, 60, 30)).count, 0);
  EXPECT_EQ(find(TriangleMesh{}).count, 0);
}

TEST(Intersect, FewPairsAreLeftToExactPredicates) {
  for (const TriangleMesh& mesh : {sphere(20, 5), moved(torus(5, 2, 150, 70), {300, -200, 100})}) {
    const std::size_t left = candidate_pairs(*backends()[0], mesh, tree_of(mesh)).size();
    EXPECT_LT(left, mesh.triangle_count() / 100);
  }
}

TEST(Intersect, TreeFindsWhatAllPairsFind) {
  const TriangleMesh mesh = joined(torus(5, 2, 37, 19), moved(sphere(3, 3), {4, 1, 0.5f}));
  std::vector<TrianglePair> wanted;
  for (std::uint32_t a = 0; a < mesh.triangle_count(); ++a)
    for (std::uint32_t b = a + 1; b < mesh.triangle_count(); ++b)
      if (triangles_intersect(mesh, a, b)) wanted.push_back({a, b});
  EXPECT_GT(wanted.size(), 100u);
  EXPECT_EQ(find(mesh).pairs, wanted);
}

TEST(Intersect, SameListForAnyNumberOfThreads) {
  const TriangleMesh mesh = joined(torus(5, 2, 201, 83), moved(torus(5, 2, 150, 71), {3, 0, 1}));
  const TriangleTree tree = tree_of(mesh);
  const Intersections one = find_intersections(*make_tbb_backend(1, nullptr), mesh, tree);
  const Intersections two = find_intersections(*make_tbb_backend(2, nullptr), mesh, tree);
  EXPECT_EQ(one.count, two.count);
  EXPECT_EQ(one.pairs, two.pairs);
  EXPECT_EQ(one.pairs.size(), Intersections::kMostListed);
  EXPECT_GT(one.count, static_cast<std::int64_t>(Intersections::kMostListed));
}

TEST(Intersect, PredicatesSigns) {
  const float a[] = {0, 0, 0}, b[] = {1, 0, 0}, c[] = {0, 1, 0}, up[] = {0, 0, 1};
  const float on[] = {7, -3, 0}, beyond[] = {2, 0, 0};
  EXPECT_EQ(orient3d(a, b, c, up), 1);
  EXPECT_EQ(orient3d(a, c, b, up), -1);
  EXPECT_EQ(orient3d(a, b, c, on), 0);
  EXPECT_EQ(orient2d(a, b, c, 2), 1);
  EXPECT_EQ(orient2d(b, a, c, 2), -1);
  EXPECT_EQ(orient2d(a, b, c, 0), 0);
  EXPECT_EQ(orient2d(a, c, up, 0), 1);
  EXPECT_TRUE(collinear(a, b, beyond));
  EXPECT_FALSE(collinear(a, b, c));
}

#ifdef VASAMESH_GPL_ORACLES
TEST(Intersect, AsCgalFinds) {
  std::mt19937 random(14);
  TriangleMesh rough = torus(5, 2, 61, 33);
  for (float& x : rough.vertices) x += static_cast<float>(random() % 1000) * 4e-4f;
  EXPECT_GT(find(rough).count, 50);
  for (const TriangleMesh& mesh :
       {rough, joined(torus(5, 2, 41, 23), moved(torus(5, 2, 35, 22), {3, 0, 1})),
        joined(sphere(3, 3), moved(sphere(3, 3), {0, 0, 5.9f}))}) {
    EXPECT_EQ(find(mesh).pairs, cgal_intersections(mesh));
  }
}
#endif

}  // namespace
}  // namespace vasamesh::test

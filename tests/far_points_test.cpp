/// \file
/// Points of a surface that are too far from another: those of all triangles quartered to the end,
/// one by one.

#include "stages/far_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "stages/distance.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

constexpr float kFinest = 0.2f;

/// The middles of the edges of a triangle and of all its quarters that are long enough.
void add_middles(const std::array<Vec3, 3>& corner, std::vector<Vec3>& points) {
  const float longest =
      std::max({squared_norm(corner[1] - corner[0]), squared_norm(corner[2] - corner[1]),
                squared_norm(corner[0] - corner[2])});
  if (longest < kFinest * kFinest) return;
  std::array<Vec3, 3> middle;
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = 0.5f * (corner[(i + 1) % 3] + corner[(i + 2) % 3]);
    points.push_back(middle[i]);
  }
  for (std::size_t i = 0; i < 3; ++i)
    add_middles({corner[i], middle[(i + 2) % 3], middle[(i + 1) % 3]}, points);
  add_middles(middle, points);
}

std::vector<Vec3> plain_points_beyond(Backend& backend, float limit, const TriangleMesh& from,
                                      const TriangleMesh& to) {
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < from.vertex_count(); ++v) points.push_back(vertex_at(from, v));
  for (std::size_t t = 0; t < from.triangle_count(); ++t)
    add_middles({vertex_at(from, from.triangles[3 * t]), vertex_at(from, from.triangles[3 * t + 1]),
                 vertex_at(from, from.triangles[3 * t + 2])},
                points);
  const std::vector<float> distances =
      distances_to(backend, points, to, build_triangle_tree(backend, to));
  std::vector<Vec3> far;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (distances[i] > limit) far.push_back(points[i]);
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  std::sort(far.begin(), far.end(), before);
  far.erase(std::unique(far.begin(), far.end()), far.end());
  return far;
}

void expect_as_plain(const TriangleMesh& from, const TriangleMesh& to,
                     std::initializer_list<float> limits) {
  const auto backend = make_tbb_backend(2, nullptr);
  const TriangleTree tree = build_triangle_tree(*backend, to);
  for (const float limit : limits) {
    const std::vector<Vec3> found = points_beyond(*backend, limit, from, to, tree);
    EXPECT_FALSE(found.empty()) << limit;
    EXPECT_EQ(found, plain_points_beyond(*backend, limit, from, to)) << limit;
  }
}

/// The sides of the triangles as triangles without area.
TriangleMesh sides_of(const TriangleMesh& mesh) {
  TriangleMesh sides;
  sides.vertices = mesh.vertices;
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c], w = mesh.triangles[c % 3 == 2 ? c - 2 : c + 1];
    add_triangle(sides, v, w, w);
  }
  return sides;
}

TEST(FarPoints, AreThoseOfAllTrianglesOneByOne) {
  const TriangleMesh fine = moved(torus(5, 2.2f, 23, 13), {0.4f, 0.1f, 0});
  expect_as_plain(fine, torus(5, 2, 7, 5), {0.3f, 0.7f, 1});
  expect_as_plain(torus(5, 2, 7, 5), fine, {0.3f, 0.7f, 1});
}

TEST(FarPoints, OfPolygonsWithAllTheirDiagonals) {
  TriangleMesh fans = torus(5, 2.4f, 19, 11);
  const std::size_t triangles = fans.triangle_count();
  for (std::uint32_t t = 0; t + 1 < triangles; t += 2) {  // both diagonals of each quadrangle
    const std::uint32_t a = fans.triangles[3 * t], b = fans.triangles[3 * t + 1],
                        c = fans.triangles[3 * t + 2], d = fans.triangles[3 * t + 5];
    add_triangle(fans, a, b, d);
    add_triangle(fans, b, c, d);
  }
  expect_as_plain(fans, torus(5, 2, 17, 12), {0.35f, 0.45f});
}

TEST(FarPoints, FromManySmallTriangles) {
  expect_as_plain(torus(5, 2.3f, 9, 7), torus(5, 2, 150, 90), {0.25f, 0.35f, 0.45f});
}

TEST(FarPoints, FromTrianglesWithoutArea) {
  expect_as_plain(torus(5, 2.2f, 23, 13), sides_of(torus(5, 2, 14, 9)), {0.3f, 0.6f});
}

TEST(FarPoints, OfVerticesWithoutTriangles) {
  TriangleMesh lone;
  add_vertex(lone, {5, 0, 0});
  add_vertex(lone, {7, 0, 0.1f});
  expect_as_plain(lone, torus(5, 2, 31, 17), {0.5f, 1});
}

TEST(FarPoints, AreFoundWhereverTheyAre) {
  const TriangleMesh fine = moved(torus(5, 2.2f, 20, 12), {0.4f, 0, 0}), coarse = torus(5, 2, 7, 5);
  const auto backend = make_tbb_backend(2, nullptr);
  const TriangleTree tree = build_triangle_tree(*backend, coarse);
  const double largest = measure_distance(*backend, fine, coarse, 1, 0.05).to.maximum;
  for (const float limit : {0.3f, 0.6f, 0.9f}) {
    const std::vector<Vec3> found = points_beyond(*backend, limit, fine, coarse, tree);
    ASSERT_FALSE(found.empty());
    const std::vector<float> distances = distances_to(*backend, found, coarse, tree);
    EXPECT_GT(*std::min_element(distances.begin(), distances.end()), limit);
    EXPECT_GT(*std::max_element(distances.begin(), distances.end()), largest - 0.05);
  }
  const auto just_below = static_cast<float>(largest) - 0.02f;
  EXPECT_FALSE(points_beyond(*backend, just_below, fine, coarse, tree).empty());
  const auto just_above = static_cast<float>(largest) + 0.01f;
  EXPECT_TRUE(points_beyond(*backend, just_above, fine, coarse, tree).empty());
  const CarefulPlace aside[] = {{{5, 0, 0}, 1, 1}};
  const Places places(aside);
  for (const Vec3& p : points_beyond(*backend, 0.3f, fine, coarse, tree, places))
    EXPECT_TRUE(places.hold(p, Places::kMargin));
}

}  // namespace
}  // namespace vasamesh::test

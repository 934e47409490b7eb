/// \file
/// Surfaces that touch themselves at vertices are taken apart there, and nothing else is changed.

#include "stages/pinches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/host_backend.h"
#include "support/invariants.h"
#include "support/shapes.h"

namespace vasamesh::test {
namespace {

/// `blades` triangles a fan, `fans` of them, all at vertex 0.
TriangleMesh fans_at_a_vertex(std::uint32_t fans, std::uint32_t blades) {
  TriangleMesh mesh;
  add_vertex(mesh, {0, 0, 0});
  for (std::uint32_t f = 0; f < fans; ++f) {
    const auto z = static_cast<float>(f + 1);
    std::uint32_t last = add_vertex(mesh, {1, 0, z});
    for (std::uint32_t i = 1; i <= blades; ++i) {
      const std::uint32_t next = add_vertex(mesh, {1, static_cast<float>(i), z});
      add_triangle(mesh, 0, last, next);
      last = next;
    }
  }
  return mesh;
}

/// Joins the vertices that lie at one place, the first of them being kept.
TriangleMesh with_vertices_joined(const TriangleMesh& mesh) {
  std::map<Vertex, std::uint32_t> known;
  TriangleMesh joint;
  std::vector<std::uint32_t> renamed;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vertex p{mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
    const auto [found, fresh] =
        known.try_emplace(p, static_cast<std::uint32_t>(joint.vertex_count()));
    if (fresh) add_vertex(joint, p);
    renamed.push_back(found->second);
  }
  for (const std::uint32_t v : mesh.triangles) joint.triangles.push_back(renamed[v]);
  return joint;
}

/// The places of the corners, in order: what a mesh is but for the names of its vertices.
std::vector<float> corners_of(const TriangleMesh& mesh) {
  std::vector<float> places;
  for (const std::uint32_t v : mesh.triangles)
    for (std::size_t a = 0; a < 3; ++a) places.push_back(mesh.vertices[3 * std::size_t{v} + a]);
  return places;
}

TriangleMesh split_apart(TriangleMesh mesh, Backend& backend = host()) {
  split_pinches(backend, mesh);
  return mesh;
}

TEST(Pinches, TrianglesThatShareADirectedEdgeGo) {
  TriangleMesh mesh = fans_at_a_vertex(1, 4);
  const TriangleMesh before = mesh;
  const std::uint32_t apart = add_vertex(mesh, {5, 5, 5});
  add_triangle(mesh, 0, 2, apart);  // the second blade has 0 -> 2 as well
  EXPECT_TRUE(drop_repeated_edges(host(), mesh));
  std::vector<std::uint32_t> left = before.triangles;
  left.erase(left.begin() + 3, left.begin() + 6);
  EXPECT_EQ(mesh.triangles, left);
  EXPECT_EQ(mesh.vertex_count(), before.vertex_count() + 1);
}

TEST(Pinches, EdgesOfOneTriangleADirectionStay) {
  TriangleMesh mesh = fans_at_a_vertex(3, 4);
  const std::uint32_t apart = add_vertex(mesh, {5, 5, 5});
  add_triangle(mesh, 1, 0, apart);  // the other side of the first blade's edge
  const TriangleMesh before = mesh;
  EXPECT_FALSE(drop_repeated_edges(host(), mesh));
  EXPECT_EQ(mesh.triangles, before.triangles);
}

TEST(Pinches, ManifoldsStayAsTheyAre) {
  for (const TriangleMesh& mesh :
       {TriangleMesh{}, tetrahedron(), torus(5, 2, 13, 7), fans_at_a_vertex(1, 4)}) {
    const TriangleMesh split = split_apart(mesh);
    EXPECT_EQ(split.vertices, mesh.vertices);
    EXPECT_EQ(split.triangles, mesh.triangles);
  }
}

TEST(Pinches, EachFurtherFanGetsAVertexOfItsOwn) {
  for (const std::uint32_t fans : {2u, 3u}) {
    const TriangleMesh mesh = fans_at_a_vertex(fans, 2);
    const TriangleMesh split = split_apart(mesh);
    ASSERT_EQ(split.vertex_count(), mesh.vertex_count() + fans - 1);
    EXPECT_EQ(corners_of(split), corners_of(mesh));
    for (std::uint32_t f = 0; f < fans; ++f)
      for (std::uint32_t t : {2 * f, 2 * f + 1})
        EXPECT_EQ(split.triangles[3 * t],
                  f == 0 ? 0 : static_cast<std::uint32_t>(mesh.vertex_count()) + f - 1);
  }
}

/// The fans lie mixed in the list: the one of the lowest corner keeps the vertex.
TEST(Pinches, TheOrderOfTrianglesDoesNotMixFans) {
  TriangleMesh mesh = fans_at_a_vertex(2, 2);
  std::swap_ranges(mesh.triangles.begin() + 3, mesh.triangles.begin() + 6,
                   mesh.triangles.begin() + 9);
  const TriangleMesh split = split_apart(mesh);
  const auto added = static_cast<std::uint32_t>(mesh.vertex_count());
  ASSERT_EQ(split.vertex_count(), mesh.vertex_count() + 1);
  for (std::size_t t = 0; t < 4; ++t)
    EXPECT_EQ(split.triangles[3 * t], t == 0 || t == 3 ? 0 : added) << t;
}

TEST(Pinches, ClosedSurfacesThatTouchAtAVertexComeApart) {
  const TriangleMesh mesh =
      with_vertices_joined(joined(box({0, 0, 0}, {1, 1, 1}), box({1, 1, 1}, {2, 3, 2})));
  ASSERT_EQ(mesh.vertex_count(), 15u);
  ASSERT_EQ(check(mesh).nonmanifold_vertices, 1);
  const TriangleMesh split = split_apart(mesh);
  EXPECT_EQ(corners_of(split), corners_of(mesh));
  const CheckReport report = check(split);
  EXPECT_EQ(split.vertex_count(), 16u);
  EXPECT_EQ(report.nonmanifold_vertices, 0);
  EXPECT_EQ(report.open_edges + report.nonmanifold_edges + report.misoriented_edges, 0);
  EXPECT_EQ(report.topology.pieces, 2);
}

/// A chain of cubes, each of which touches the next at a vertex.
TEST(Pinches, AreTakenApartAlikeByAnyThreads) {
  constexpr int kCubes = 1500;
  TriangleMesh chain;
  for (int i = 0; i < kCubes; ++i) {
    const auto low = static_cast<float>(i), high = static_cast<float>(i + 1);
    chain = joined(std::move(chain), box({low, low, low}, {high, high, high}));
  }
  const TriangleMesh mesh = with_vertices_joined(chain);
  ASSERT_EQ(mesh.vertex_count(), 7u * kCubes + 1);
  const auto one = make_tbb_backend(1, nullptr);
  const TriangleMesh split = split_apart(mesh, *one);
  EXPECT_EQ(split.vertex_count(), 8u * kCubes);
  EXPECT_EQ(check(split).nonmanifold_vertices, 0);
  for (const int threads : {2, 4}) {
    const auto more = make_tbb_backend(threads, nullptr);
    const TriangleMesh other = split_apart(mesh, *more);
    EXPECT_EQ(other.triangles, split.triangles);
    EXPECT_EQ(other.vertices, split.vertices);
  }
}

}  // namespace
}  // namespace vasamesh::test

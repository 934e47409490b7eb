/// \file
/// The half-edges of a part of a surface: each operation on a small mesh by hand, what the link
/// condition and the borders refuse, and that no sequence of operations changes the topology.

#include "stages/patch_mesh.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "stages/patch_blocks.h"
#include "support/host_backend.h"
#include "support/invariants.h"
#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

constexpr std::uint32_t kNone = PatchMesh::kNone;

PatchMesh patch_of(const TriangleMesh& mesh, std::vector<std::uint8_t> whole = {}) {
  std::vector<SurfacePoint> points(mesh.vertex_count());
  for (std::size_t v = 0; v < points.size(); ++v)
    points[v].position = {mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
  whole.resize(points.size(), 1);
  PatchMesh patch;
  patch.build(std::move(points), mesh.triangles, std::move(whole));
  return patch;
}

TriangleMesh mesh_of(const PatchMesh& patch) {
  WorkingSurface surface;
  surface.points = patch.points;
  for (std::uint32_t h = 0; h < patch.half_edge_end(); ++h)
    if (patch.is_edge(h)) surface.triangles.push_back(patch.origin(h));
  return make_mesh(host(), surface);
}

/// The half-edge between two vertices, or kNone.
std::uint32_t edge_between(const PatchMesh& patch, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t h = 0; h < patch.half_edge_end(); ++h)
    if (patch.is_edge(h) && patch.origin(h) == from && patch.target(h) == to) return h;
  return kNone;
}

/// Twins name each other and run against each other; each vertex starts at a half-edge of its own,
/// on a border at the border's, and its fan is complete.
void expect_sound(const PatchMesh& patch) {
  std::vector<int> triangles_at(patch.vertex_count(), 0);
  for (std::uint32_t h = 0; h < patch.half_edge_end(); ++h) {
    if (!patch.is_edge(h)) continue;
    ++triangles_at[patch.origin(h)];
    const std::uint32_t t = patch.twin(h);
    if (t == kNone) continue;
    ASSERT_EQ(patch.twin(t), h);
    ASSERT_EQ(patch.origin(t), patch.target(h));
    ASSERT_EQ(patch.target(t), patch.origin(h));
  }
  for (std::uint32_t v = 0; v < patch.vertex_count(); ++v) {
    if (!patch.is_there(v)) continue;
    ASSERT_EQ(patch.fan_size(v), triangles_at[v]) << "vertex " << v;
    patch.for_each_out(v, [&](std::uint32_t h) { ASSERT_EQ(patch.origin(h), v); });
  }
}

/// A fan of `n` triangles round vertex 0, open or closed.
TriangleMesh fan(int n, bool closed) {
  TriangleMesh mesh;
  add_vertex(mesh, {0, 0, 0});
  for (int i = 0; i < n + (closed ? 0 : 1); ++i) add_vertex(mesh, {static_cast<float>(i), 1, 0});
  for (int i = 0; i < n; ++i) add_triangle(mesh, 0, 1 + i, closed ? 1 + (i + 1) % n : 2 + i);
  return mesh;
}

TEST(PatchMesh, FansAndBorders) {
  const PatchMesh closed = patch_of(fan(5, true));
  EXPECT_EQ(closed.fan_size(0), 5);
  EXPECT_TRUE(closed.is_inner(0));
  EXPECT_TRUE(closed.is_border(3));
  const PatchMesh open = patch_of(fan(5, false));
  EXPECT_TRUE(open.is_border(0));
  EXPECT_EQ(open.fan_size(0), 5);
  EXPECT_TRUE(open.are_joined(0, 6));
  EXPECT_FALSE(open.are_joined(1, 3));
  expect_sound(closed);
  expect_sound(open);
}

TEST(PatchMesh, CollapseMergesAVertexIntoItsNeighbour) {
  PatchMesh patch = patch_of(fan(6, true));
  const std::uint32_t h = edge_between(patch, 0, 1);
  ASSERT_TRUE(patch.may_collapse(h, 0, 1));
  patch.collapse(h, 0, 1);
  expect_sound(patch);
  EXPECT_FALSE(patch.is_there(0));
  EXPECT_EQ(mesh_of(patch).triangle_count(), 4u);
  EXPECT_TRUE(patch.is_border(1));
  EXPECT_EQ(patch.fan_size(1), 4);
}

TEST(PatchMesh, ABorderVertexStaysOnItsBorder) {
  PatchMesh patch = patch_of(fan(8, true));
  EXPECT_FALSE(patch.may_collapse(edge_between(patch, 1, 0), 1, 0));
  const std::uint32_t border = edge_between(patch, 1, 2);
  ASSERT_EQ(patch.twin(border), kNone);
  ASSERT_TRUE(patch.may_collapse(border, 1, 2));
  patch.collapse(border, 1, 2);
  expect_sound(patch);
  EXPECT_EQ(patch.fan_size(0), 7);
  const std::uint32_t next = edge_between(patch, 2, 3);
  ASSERT_TRUE(patch.may_collapse(next, 3, 2));
  patch.collapse(next, 3, 2);
  expect_sound(patch);
  EXPECT_EQ(patch.fan_size(0), 6);
}

TEST(PatchMesh, ALoopKeepsSixEdges) {
  PatchMesh six = patch_of(fan(6, true));
  EXPECT_FALSE(six.may_collapse(edge_between(six, 1, 2), 1, 2));
  PatchMesh seven = patch_of(fan(7, true));
  EXPECT_TRUE(seven.may_collapse(edge_between(seven, 1, 2), 1, 2));
}

TEST(PatchMesh, AnEdgeAcrossFromBorderToBorderStays) {
  // Two triangles in a strip of six: the edges between them join two border vertices.
  TriangleMesh strip;
  for (int i = 0; i < 12; ++i) add_vertex(strip, {static_cast<float>(i), i % 2 ? 1.0f : 0.0f, 0});
  for (std::uint32_t i = 0; i < 10; ++i)
    i % 2 ? add_triangle(strip, i, i + 2, i + 1) : add_triangle(strip, i, i + 1, i + 2);
  PatchMesh patch = patch_of(turned_inside_out(strip));
  expect_sound(patch);
  const std::uint32_t h =
      edge_between(patch, 4, 5) != kNone ? edge_between(patch, 4, 5) : edge_between(patch, 5, 4);
  ASSERT_NE(patch.twin(h), kNone);
  EXPECT_FALSE(patch.may_collapse(h, 4, 5));
  EXPECT_FALSE(patch.may_collapse(h, 5, 4));
}

TEST(PatchMesh, ATetrahedronStays) {
  PatchMesh patch = patch_of(tetrahedron());
  for (std::uint32_t h = 0; h < patch.half_edge_end(); ++h) {
    if (!patch.is_edge(h)) continue;
    EXPECT_FALSE(patch.may_collapse(h, patch.origin(h), patch.target(h)));
    EXPECT_FALSE(patch.may_flip(h));
  }
}

TEST(PatchMesh, NoInnerVertexIsLeftWithThreeTriangles) {
  // Two caps of four triangles: each collapse would leave two of their corners with three.
  TriangleMesh octahedron;
  for (const Vertex& v :
       {Vertex{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})
    add_vertex(octahedron, v);
  for (std::uint32_t i = 0; i < 4; ++i) {
    add_triangle(octahedron, i, (i + 1) % 4, 4);
    add_triangle(octahedron, (i + 1) % 4, i, 5);
  }
  PatchMesh patch = patch_of(octahedron);
  expect_sound(patch);
  for (std::uint32_t h = 0; h < patch.half_edge_end(); ++h)
    if (patch.is_edge(h)) {
      EXPECT_FALSE(patch.may_collapse(h, patch.origin(h), patch.target(h)));
    }
  // With a vertex more on an edge there are five at the corners beside it.
  const std::uint32_t h = edge_between(patch, 0, 1);
  const std::uint32_t middle = patch.split(h, patch.points[0]);
  EXPECT_TRUE(patch.may_collapse(edge_between(patch, 0, middle), middle, 0));
}

TEST(PatchMesh, AHeldBorderStays) {
  PatchMesh patch = patch_of(fan(8, true));
  patch.hold_border();
  const std::uint32_t border = edge_between(patch, 1, 2);
  EXPECT_FALSE(patch.may_collapse(border, 1, 2));
  EXPECT_FALSE(patch.may_collapse(edge_between(patch, 0, 1), 0, 1));
  EXPECT_TRUE(patch.is_inner(0));
}

TEST(PatchMesh, ATubeOfThreeEdgesRoundIsNotPinched) {
  // Rings of three vertices: an edge of a ring has three common neighbours with its ends.
  TriangleMesh tube;
  constexpr std::uint32_t kRings = 6;
  for (std::uint32_t r = 0; r < kRings; ++r)
    for (std::uint32_t i = 0; i < 3; ++i)
      add_vertex(tube, {static_cast<float>(i), static_cast<float>(i * i), static_cast<float>(r)});
  for (std::uint32_t r = 0; r + 1 < kRings; ++r)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = 3 * r + i, b = 3 * r + (i + 1) % 3;
      add_triangle(tube, a, b, a + 3);
      add_triangle(tube, b, b + 3, a + 3);
    }
  PatchMesh patch = patch_of(tube);
  const std::uint32_t round = edge_between(patch, 6, 7), along = edge_between(patch, 6, 9);
  EXPECT_FALSE(patch.may_collapse(round, 6, 7));
  ASSERT_NE(along, kNone);
  EXPECT_TRUE(patch.may_collapse(along, 6, 9));
}

TEST(PatchMesh, VerticesOnTheCutStay) {
  std::vector<std::uint8_t> whole(7, 1);
  whole[1] = 0;
  PatchMesh patch = patch_of(fan(6, true), whole);
  EXPECT_FALSE(patch.may_collapse(edge_between(patch, 0, 1), 0, 1));
  EXPECT_TRUE(patch.may_collapse(edge_between(patch, 0, 3), 0, 3));
  EXPECT_FALSE(patch.may_flip(edge_between(patch, 0, 2)));
  EXPECT_TRUE(patch.may_flip(edge_between(patch, 0, 4)));
}

TEST(PatchMesh, FlipTurnsAnEdge) {
  PatchMesh patch = patch_of(fan(4, true));
  const std::uint32_t h = edge_between(patch, 0, 2);
  ASSERT_TRUE(patch.may_flip(h));
  patch.flip(h);
  expect_sound(patch);
  EXPECT_EQ(patch.fan_size(0), 3);
  EXPECT_TRUE(patch.are_joined(1, 3));
  EXPECT_FALSE(patch.are_joined(0, 2));
  EXPECT_FALSE(patch.may_flip(edge_between(patch, 0, 4)));  // 1 and 3 are joined already
}

TEST(PatchMesh, SplitOfAnInnerAndOfABorderEdge) {
  PatchMesh patch = patch_of(fan(5, true));
  const std::uint32_t inner = patch.split(edge_between(patch, 0, 2), {});
  expect_sound(patch);
  EXPECT_EQ(patch.fan_size(inner), 4);
  EXPECT_TRUE(patch.is_inner(inner));
  const std::uint32_t border = patch.split(edge_between(patch, 4, 5), {});
  expect_sound(patch);
  EXPECT_EQ(patch.fan_size(border), 2);
  EXPECT_TRUE(patch.is_border(border));
  EXPECT_EQ(mesh_of(patch).triangle_count(), 8u);
}

/// Thousands of operations at random, whatever they do to the shape.
TEST(PatchMesh, NoSequenceOfOperationsChangesTheTopology) {
  for (const auto& [start, genus] :
       {std::pair{sphere(1, 2), 0}, {torus(3, 1, 14, 9), 1}, {tetrahedron(), 0}}) {
    PatchMesh patch = patch_of(start);
    std::mt19937 random(7);
    int collapses = 0, flips = 0;
    for (int i = 0; i < 6000; ++i) {
      const std::uint32_t h = random() % patch.half_edge_end();
      if (!patch.is_edge(h)) continue;
      const int choice = static_cast<int>(random() % 8);
      const std::uint32_t v = patch.origin(h), w = patch.target(h);
      if (choice < 4 && patch.may_collapse(h, v, w)) {
        patch.collapse(h, v, w);
        ++collapses;
      } else if (choice < 7 && patch.may_flip(h)) {
        patch.flip(h);
        ++flips;
      } else if (choice == 7) {
        patch.split(h, patch.points[v]);
      }
    }
    expect_sound(patch);
    EXPECT_GT(collapses, 50);
    EXPECT_GT(flips, 50);
    const CheckReport report = check(mesh_of(patch));
    EXPECT_EQ(report.open_edges + report.nonmanifold_edges + report.misoriented_edges, 0);
    EXPECT_EQ(report.nonmanifold_vertices, 0);
    EXPECT_EQ(report.shell_genus, std::vector<std::int64_t>{genus});
  }
}

TEST(PatchMesh, NoSequenceOfOperationsOpensABorder) {
  TriangleMesh sheet;
  constexpr std::uint32_t kSide = 9;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i)
    add_vertex(sheet, {static_cast<float>(i % kSide), static_cast<float>(i / kSide), 0});
  for (std::uint32_t y = 0; y + 1 < kSide; ++y)
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t a = x + kSide * y;
      if (x == 4 && y == 4) continue;  // a hole
      add_triangle(sheet, a, a + 1, a + kSide + 1);
      add_triangle(sheet, a, a + kSide + 1, a + kSide);
    }
  PatchMesh patch = patch_of(sheet);
  std::mt19937 random(11);
  for (int i = 0; i < 4000; ++i) {
    const std::uint32_t h = random() % patch.half_edge_end();
    if (!patch.is_edge(h)) continue;
    const std::uint32_t v = patch.origin(h), w = patch.target(h);
    if (i % 3 == 0 && patch.may_collapse(h, v, w)) patch.collapse(h, v, w);
    if (i % 3 == 1 && patch.is_edge(h) && patch.may_flip(h)) patch.flip(h);
    if (i % 24 == 2) patch.split(h, patch.points[v]);
  }
  expect_sound(patch);
  std::uint32_t border_edges = 0, edges = 0, triangles = 0, vertices = 0;
  for (std::uint32_t h = 0; h < patch.half_edge_end(); ++h) {
    if (!patch.is_edge(h)) continue;
    ++edges;
    border_edges += patch.twin(h) == kNone;
  }
  triangles = edges / 3;
  edges = (edges + border_edges) / 2;
  for (std::uint32_t v = 0; v < patch.vertex_count(); ++v) vertices += patch.is_there(v);
  EXPECT_EQ(vertices + triangles, edges) << "a sheet with one hole";
  EXPECT_GE(border_edges, 6u + 4u);  // the hole has its four edges still
  EXPECT_LT(triangles, 2u * 63);
}

}  // namespace
}  // namespace vasamesh::test

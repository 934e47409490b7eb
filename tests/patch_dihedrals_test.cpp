/// \file
/// Sharp edges are opened: on small shapes by hand and on flattened ones at random.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "stages/intersect.h"
#include "stages/patch_passes.h"
#include "stages/quality.h"
#include "stages/triangle_tree.h"
#include "support/patches.h"
#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

QualityReport quality_of(const PatchMesh& patch) {
  return measure_quality(*make_tbb_backend(1, nullptr), mesh_of(patch));
}

std::size_t meeting_pairs(const PatchMesh& patch) {
  const auto backend = make_tbb_backend(1, nullptr);
  const TriangleMesh mesh = mesh_of(patch);
  return find_intersections(*backend, mesh, build_triangle_tree(*backend, mesh)).pairs.size();
}

/// A ring of the tube radius 1 whose height is made `share` of it, shaken by up to `shake`, at
/// places that are not negative.
TriangleMesh flat_ring(float share, float shake, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> by(-shake, shake);
  TriangleMesh mesh = torus(4, 1, 24, 6);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (i % 3 == 2) mesh.vertices[i] *= share;
    mesh.vertices[i] += 8 + by(random);
  }
  return mesh;
}

/// A roof over the edge from (7, 8, 8) to (9, 8, 8), its eaves `width` apart and 1 below, with a
/// strip of a hundred triangles at one of its sides: it is no small shell.
TriangleMesh roof(float width) {
  constexpr std::uint32_t kStrip = 100;
  TriangleMesh mesh;
  for (const Vertex& p : {Vertex{8, 8 - width / 2, 7}, {7, 8, 8}, {8, 8 + width / 2, 7}, {9, 8, 8}})
    add_vertex(mesh, p);
  add_triangle(mesh, 1, 3, 2);
  add_triangle(mesh, 3, 1, 0);
  for (std::uint32_t v = 2; v < kStrip + 2; ++v) {
    add_vertex(mesh, {v % 2 == 0 ? 8.0f : 9.0f, 8 + 0.5f * static_cast<float>(v), 7});
    add_triangle(mesh, v + v % 2, v + 1 - v % 2, v + 2);
  }
  return mesh;
}

TEST(PatchDihedrals, ASharpRidgeIsTurned) {
  PatchMesh patch = patch_of(roof(1));
  ASSERT_EQ(quality_of(patch).sharp_edges, 1);
  open_dihedrals(patch, 1);
  EXPECT_EQ(quality_of(patch).sharp_edges, 0);
  EXPECT_EQ(quality_of(patch).dihedral_angle.minimum, 90);
}

TEST(PatchDihedrals, ARidgeThatIsNotSharpStays) {
  const TriangleMesh blunt = roof(1.2f);
  PatchMesh patch = patch_of(blunt);
  open_dihedrals(patch, 4);
  EXPECT_EQ(mesh_of(patch).triangles, blunt.triangles);
}

TEST(PatchDihedrals, ARidgeIsNotTurnedIntoWhatLiesInside) {
  TriangleMesh mesh = roof(1);
  const std::uint32_t first = add_vertex(mesh, {7.9f, 8, 7.1f});
  add_vertex(mesh, {8.1f, 8, 7.1f});
  add_vertex(mesh, {8, 8, 6.5f});
  add_triangle(mesh, first, first + 1, first + 2);
  PatchMesh patch = patch_of(mesh);
  open_dihedrals(patch, 4);
  EXPECT_EQ(mesh_of(patch).triangles, mesh.triangles);
}

TEST(PatchDihedrals, ShapesWithoutSharpEdgesStayAsTheyAre) {
  for (const TriangleMesh& mesh : {box({4, 4, 4}, {6, 6, 6}), moved(sphere(3, 2), {8, 8, 8})}) {
    PatchMesh patch = patch_of(mesh);
    open_dihedrals(patch, 4);
    EXPECT_EQ(mesh_of(patch).vertices, mesh.vertices);
    EXPECT_EQ(mesh_of(patch).triangles, mesh.triangles);
  }
}

TEST(PatchDihedrals, AVertexThatLeansOutComesBack) {
  // The top of a ball, drawn out to its side until triangles lie upon each other.
  TriangleMesh mesh = moved(sphere(2, 2), {8, 8, 8});
  std::uint32_t top = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.vertices[3 * v + 2] > mesh.vertices[3 * top + 2]) top = v;
  mesh.vertices[3 * top] += 1;
  mesh.vertices[3 * top + 2] += 0.1f;
  PatchMesh patch = patch_of(mesh);
  ASSERT_GT(quality_of(patch).sharp_edges, 0);
  ASSERT_EQ(meeting_pairs(patch), 0u);
  open_dihedrals(patch, 8);
  EXPECT_EQ(quality_of(patch).sharp_edges, 0);
  EXPECT_EQ(meeting_pairs(patch), 0u);
}

TEST(PatchDihedrals, VerticesThatAreNotWholeStay) {
  const TriangleMesh mesh = flat_ring(0.15f, 0, 1);
  PatchMesh patch = patch_of(mesh, [](const Vec3& p) { return p.x > 8; });
  open_dihedrals(patch, 8);
  std::size_t moved_ones = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 before = vertex_at(mesh, v), after = patch.points[v].position;
    if (before.x <= 8)
      EXPECT_EQ(after, before);
    else
      moved_ones += !(after == before);
  }
  EXPECT_GT(moved_ones, 0u);
}

TEST(PatchDihedrals, FlatRingsAreOpenedAndStayRings) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    PatchMesh patch = patch_of(flat_ring(0.15f, 0.04f, seed));
    const QualityReport before = quality_of(patch);
    ASSERT_GT(before.sharp_edges, 20) << "seed " << seed;
    ASSERT_EQ(meeting_pairs(patch), 0u) << "seed " << seed;
    open_dihedrals(patch, 8);
    const QualityReport after = quality_of(patch);
    EXPECT_EQ(after.sharp_edges, 0) << "seed " << seed;
    EXPECT_EQ(meeting_pairs(patch), 0u) << "seed " << seed;
    EXPECT_GE(after.least_angle.minimum, std::min(25.0, before.least_angle.minimum) - 0.01);
    EXPECT_GT(after.volume, before.volume) << "seed " << seed;
    const TriangleMesh mesh = mesh_of(patch);
    std::size_t vertices = 0;
    for (std::uint32_t v = 0; v < patch.vertex_count(); ++v) vertices += patch.is_there(v);
    EXPECT_EQ(2 * vertices, mesh.triangle_count()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace vasamesh::test

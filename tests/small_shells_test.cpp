/// \file
/// Small shells are not turned inside out: closed ones, and what a part has of one.

#include "stages/small_shells.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/patch_clearance.h"
#include "support/patches.h"
#include "support/shapes.h"

namespace vasamesh::test {
namespace {

/// A ball of 42 vertices and 80 triangles.
TriangleMesh small_ball() { return moved(sphere(1, 1), {5, 5, 5}); }

std::uint32_t highest(const PatchMesh& mesh) {
  const auto most = std::max_element(
      mesh.points.begin(), mesh.points.end(),
      [](const SurfacePoint& a, const SurfacePoint& b) { return a.position.z < b.position.z; });
  return static_cast<std::uint32_t>(most - mesh.points.begin());
}

/// Whether the shell keeps its volume with the vertex at a place.
bool keeps(const SmallShells& shells, PatchMesh& mesh, std::uint32_t v, const Vec3& place) {
  const Vec3 old = mesh.points[v].position;
  mesh.points[v].position = place;
  std::vector<std::uint32_t> fan;
  std::vector<SmallShells::Corners> corners;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    fan.push_back(h);
    corners.push_back({v, mesh.target(h), mesh.apex(h)});
  });
  const bool kept = shells.keep_volume(mesh, fan, corners);
  mesh.points[v].position = old;
  return kept;
}

TEST(SmallShells, MovesThatTurnOneInsideOutAreRefused) {
  for (const bool inward : {false, true}) {
    PatchMesh mesh = patch_of(inward ? turned_inside_out(small_ball()) : small_ball());
    const SmallShells shells(mesh);
    const std::uint32_t top = highest(mesh);
    const Vec3 at = mesh.points[top].position;
    EXPECT_TRUE(keeps(shells, mesh, top, at + Vec3{0, 0, 1}));
    EXPECT_TRUE(keeps(shells, mesh, top, at - Vec3{0, 0, 0.3f}));
    EXPECT_FALSE(keeps(shells, mesh, top, at - Vec3{0, 0, 20}));
  }
}

TEST(SmallShells, LargerOnesMayDoAsTheyLike) {
  PatchMesh mesh = patch_of(moved(sphere(1, 2), {5, 5, 5}));
  const SmallShells shells(mesh);
  const std::uint32_t top = highest(mesh);
  EXPECT_TRUE(keeps(shells, mesh, top, mesh.points[top].position - Vec3{0, 0, 50}));
}

TEST(SmallShells, ThePartOfAShellInABlockIsOne) {
  // What lies above z = 5 is whole; the rim below it belongs to another block too.
  TriangleMesh half = small_ball();
  std::vector<std::uint32_t> kept;
  for (std::size_t t = 0; t < half.triangles.size(); t += 3)
    if (std::any_of(&half.triangles[t], &half.triangles[t] + 3,
                    [&](std::uint32_t v) { return half.vertices[3 * v + 2] > 5.01f; }))
      kept.insert(kept.end(), &half.triangles[t], &half.triangles[t] + 3);
  half.triangles = kept;
  PatchMesh mesh = patch_of(half, [](const Vec3& p) { return p.z > 5.01f; });
  const SmallShells shells(mesh);
  const std::uint32_t top = highest(mesh);
  const Vec3 at = mesh.points[top].position;
  EXPECT_TRUE(keeps(shells, mesh, top, at - Vec3{0, 0, 0.2f}));
  EXPECT_FALSE(keeps(shells, mesh, top, at - Vec3{0, 0, 20}));
}

TEST(SmallShells, AFlatPatchIsNone) {
  TriangleMesh flat;
  for (int i = 0; i < 16; ++i) add_vertex(flat, {1.0f * (i % 4), 1.0f * (i / 4), 1});
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = 0; x < 3; ++x) {
      const std::uint32_t v = 4 * y + x;
      add_triangle(flat, v, v + 1, v + 5);
      add_triangle(flat, v, v + 5, v + 4);
    }
  PatchMesh mesh = patch_of(flat, [](const Vec3& p) { return p.x == 1 && p.y == 1; });
  const SmallShells shells(mesh);
  for (const float z : {-9.0f, 11.0f}) EXPECT_TRUE(keeps(shells, mesh, 5, {1, 1, z}));
}

TEST(SmallShells, CollapsesCountWithWhatTheyLeave) {
  PatchMesh mesh = patch_of(small_ball());
  const SmallShells shells(mesh);
  const std::uint32_t top = highest(mesh);
  std::vector<std::uint32_t> fan;
  mesh.for_each_out(top, [&](std::uint32_t h) { fan.push_back(h); });
  const std::uint32_t kept = mesh.target(fan.front());
  std::vector<SmallShells::Corners> made;
  for (const std::uint32_t h : fan)
    if (mesh.target(h) != kept && mesh.apex(h) != kept)
      made.push_back({kept, mesh.target(h), mesh.apex(h)});
  EXPECT_TRUE(shells.keep_volume(mesh, fan, made));
  mesh.points[kept].position.z -= 40;  // and so do the triangles that stay
  EXPECT_FALSE(shells.keep_volume(mesh, fan, made));
}

TEST(SmallShells, ClearanceAsksThem) {
  PatchMesh mesh = patch_of(small_ball());
  Clearance clearance(mesh);
  // A new vertex on an edge is of the shell too.
  const std::uint32_t top = highest(mesh);
  std::uint32_t edge = 0;
  mesh.for_each_out(top, [&](std::uint32_t h) { edge = h; });
  SurfacePoint middle = mesh.points[top];
  middle.position = 0.5f * (middle.position + mesh.points[mesh.target(edge)].position);
  const std::uint32_t added = mesh.split(edge, middle);
  mesh.for_each_out(added, [&](std::uint32_t h) { clearance.take_up(mesh, h); });
  SurfacePoint through = mesh.points[added];
  through.position = through.position + 40.0f * (Vec3{5, 5, 5} - through.position);
  EXPECT_FALSE(clearance.move_if_clear(mesh, added, through));
}

}  // namespace
}  // namespace vasamesh::test

/// \file
/// Handles that one of two surfaces lacks are found by the sums of their angles; other
/// triangulations of the same shape differ nowhere.

#include "stages/angle_defects.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

std::vector<Vec3> both_ways(const TriangleMesh& a, const TriangleMesh& b) {
  const std::shared_ptr<Backend> backend = make_tbb_backend(2, nullptr);
  const std::vector<Vec3> found = angle_defect_differences(*backend, a, b),
                          back = angle_defect_differences(*backend, b, a);
  EXPECT_EQ(found.size(), back.size());
  return found;
}

TEST(AngleDefects, NoneBetweenTriangulationsOfOneShape) {
  EXPECT_TRUE(both_ways(sphere(9, 3), sphere(9, 4)).empty());
  EXPECT_TRUE(both_ways(torus(9, 3, 60, 30), torus(9, 3, 47, 23)).empty());
  EXPECT_TRUE(both_ways(torus(9, 3, 60, 30), torus(9.05f, 3.1f, 60, 30)).empty());
}

TEST(AngleDefects, AMissingPieceIsFoundWhereItIs) {
  const Vertex place{21, 30, 13};
  const TriangleMesh one = sphere(9, 4);
  const std::vector<Vec3> found = both_ways(one, joined(one, moved(sphere(1, 2), place)));
  ASSERT_FALSE(found.empty());
  for (const Vec3& p : found)
    for (const float off : {p.x - place[0], p.y - place[1], p.z - place[2]})
      EXPECT_LE(std::fabs(off), 4);
}

/// A box with a square hole through it along z, or with the hole's ends closed flat.
TriangleMesh drilled_box(bool open) {
  TriangleMesh mesh;
  const auto ring = [&](float half, float z) {
    const std::uint32_t first = add_vertex(mesh, {-half, -half, z});
    add_vertex(mesh, {half, -half, z});
    add_vertex(mesh, {half, half, z});
    add_vertex(mesh, {-half, half, z});
    return first;
  };
  // Between two rings, counter-clockwise seen from outside where `a` lies below `b`.
  const auto wall = [&](std::uint32_t a, std::uint32_t b) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t j = (i + 1) % 4;
      add_triangle(mesh, a + i, a + j, b + j);
      add_triangle(mesh, a + i, b + j, b + i);
    }
  };
  const std::uint32_t low = ring(12, 1), high = ring(12, 3);
  const std::uint32_t low_hole = ring(1, 1), high_hole = ring(1, 3);
  wall(low, high);
  wall(high, high_hole);
  wall(low_hole, low);
  if (open) {
    wall(high_hole, low_hole);
  } else {
    add_triangle(mesh, high_hole, high_hole + 1, high_hole + 2);
    add_triangle(mesh, high_hole, high_hole + 2, high_hole + 3);
    add_triangle(mesh, low_hole, low_hole + 2, low_hole + 1);
    add_triangle(mesh, low_hole, low_hole + 3, low_hole + 2);
  }
  return mesh;
}

TEST(AngleDefects, AMissingHandleIsFoundWhereItIs) {
  // Into the middle of one of the grids' cubes.
  const Vertex place{4, 4, 2};
  const std::vector<Vec3> found =
      both_ways(moved(drilled_box(true), place), moved(drilled_box(false), place));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (Vec3{4, 4, 4}));
}

}  // namespace
}  // namespace vasamesh::test

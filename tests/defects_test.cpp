/// \file
/// Where a surface fails: open edges, triangles that meet, handles and pieces that the base surface
/// lacks.

#include "stages/defects.h"

#include <gtest/gtest.h>

#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

class Defects : public ::testing::Test {
 protected:
  std::vector<Vec3> between(const TriangleMesh& base, const TriangleMesh& mesh,
                            bool meets_itself = false) const {
    return find_defects(*backend_, base, build_triangle_tree(*backend_, base), mesh, meets_itself);
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  const TriangleMesh ball_ = moved(sphere(9, 4), {20, 20, 20});
};

TEST_F(Defects, OneShapeHasNone) {
  const TriangleMesh coarse = moved(sphere(9, 3), {20, 20, 20});
  EXPECT_TRUE(has_topology_of(*backend_, ball_, coarse));
  EXPECT_TRUE(between(ball_, coarse).empty());
}

TEST_F(Defects, AnOpenEdgeIsOne) {
  TriangleMesh open = ball_;
  const Vec3 corner = {open.vertices[3 * open.triangles[0]],
                       open.vertices[3 * open.triangles[0] + 1],
                       open.vertices[3 * open.triangles[0] + 2]};
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 3);
  EXPECT_FALSE(has_topology_of(*backend_, ball_, open));
  const std::vector<Vec3> found = between(ball_, open);
  ASSERT_EQ(found.size(), 3u);
  for (const Vec3& p : found) EXPECT_LT(norm(p - corner), 3);
}

TEST_F(Defects, AnotherEulerNumberIsAnotherTopology) {
  EXPECT_FALSE(has_topology_of(*backend_, ball_, moved(torus(9, 3, 60, 30), {20, 20, 20})));
}

TEST_F(Defects, APieceThatTheBaseLacksIsFoundAllOver) {
  const Vertex place = {47, 21, 14};
  const TriangleMesh two = joined(ball_, moved(sphere(1, 2), place));
  for (const auto& found : {between(ball_, two), between(two, ball_)}) {
    EXPECT_GE(found.size(), 160u);  // of 162 vertices
    for (const Vec3& p : found) EXPECT_LT(norm(p - Vec3{place[0], place[1], place[2]}), 1.01f);
  }
}

TEST_F(Defects, TrianglesThatMeetAreFoundWhereTheyDo) {
  const TriangleMesh two = joined(ball_, moved(sphere(3, 2), {29, 20, 20}));
  const std::vector<Vec3> found = between(two, two, true);
  ASSERT_FALSE(found.empty());
  for (const Vec3& p : found) {
    EXPECT_NEAR(norm(p - Vec3{20, 20, 20}), 9, 1.5);
    EXPECT_NEAR(norm(p - Vec3{29, 20, 20}), 3, 1.5);
  }
}

}  // namespace
}  // namespace vasamesh::test

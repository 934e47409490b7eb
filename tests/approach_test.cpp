/// \file
/// Surfaces brought near points that they have left.

#include "stages/approach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "stages/distance.h"
#include "stages/remesh.h"
#include "stages/sizing.h"
#include "stages/triangle_tree.h"
#include "support/analytic_lattice.h"
#include "support/invariants.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

/// A tube with round ends in edges much too long for it.
class ApproachTest : public ::testing::Test {
 protected:
  ApproachTest()
      : scene_(*backend_, {32, 16, 16}, capsule({8, 8, 8}, {24, 8, 8}, 3)),
        sizes_(make_sizes(*backend_, scene_.field, scene_.surface,
                          {.rho = 1, .edge_min = 2.2f, .edge_max = 2.6f})),
        mesh_(remesh(*backend_, scene_.field.view(), sizes_.view(scene_.field), scene_.surface)) {
    for (std::size_t i = 0; i < scene_.surface.vertices.size(); i += 3)
      points_.push_back({scene_.surface.vertices[i], scene_.surface.vertices[i + 1],
                         scene_.surface.vertices[i + 2]});
  }

  TriangleMesh near(std::span<const Vec3> points, float farthest, Backend& on) const {
    return approach(on, scene_.field.view(), sizes_.view(scene_.field), points, farthest, mesh_);
  }
  float farthest_from(const TriangleMesh& mesh, std::span<const Vec3> points) const {
    const auto distances =
        distances_to(*backend_, points, mesh, build_triangle_tree(*backend_, mesh));
    return *std::max_element(distances.begin(), distances.end());
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  AnalyticScene scene_;
  SizeField sizes_;
  TriangleMesh mesh_;
  std::vector<Vec3> points_;
};

TEST_F(ApproachTest, NothingChangesWhereNoPointIsFar) {
  const TriangleMesh mesh = near(points_, farthest_from(mesh_, points_), *backend_);
  EXPECT_EQ(mesh.vertices, mesh_.vertices);
  EXPECT_EQ(mesh.triangles, mesh_.triangles);
}

TEST_F(ApproachTest, LongChordsAreSplit) {
  const float before = farthest_from(mesh_, points_);
  const TriangleMesh mesh = near(points_, 0.8f * before, *backend_);
  EXPECT_LE(farthest_from(mesh, points_), 0.8f * before);
  EXPECT_GT(mesh.triangle_count(), mesh_.triangle_count());
  EXPECT_LT(mesh.triangle_count(), 2 * mesh_.triangle_count());
  expect_good_surface(mesh, Topology{1, 0, 0});
}

TEST_F(ApproachTest, ATipIsDrawnOut) {
  const Vec3 beyond[] = {{28.2f, 8, 8}};
  ASSERT_GT(farthest_from(mesh_, beyond), 1.1f);
  const TriangleMesh mesh = near(beyond, 0.6f, *backend_);
  EXPECT_LE(farthest_from(mesh, beyond), 0.6f);
  expect_good_surface(mesh, Topology{1, 0, 0});
}

TEST_F(ApproachTest, StrayVerticesComeBack) {
  const TriangleTree tree = build_triangle_tree(*backend_, mesh_);
  TriangleMesh pulled = mesh_;
  for (int i = 0; i < 3; ++i) pulled.vertices[i] += 1.2f * (mesh_.vertices[i] < 8 ? -0.5f : 0.5f);
  const std::vector<Vec3> first = {{pulled.vertices[0], pulled.vertices[1], pulled.vertices[2]}};
  ASSERT_GT(farthest_from(mesh_, first), 0.4f);
  const TriangleMesh mesh = bring_back(*backend_, scene_.field.view(), sizes_.view(scene_.field),
                                       mesh_, tree, 0.2f, pulled);
  EXPECT_EQ(mesh.triangle_count(), mesh_.triangle_count());
  std::vector<Vec3> all;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3)
    all.push_back({mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]});
  EXPECT_LE(farthest_from(mesh_, all), 0.2f);
  expect_good_surface(mesh, Topology{1, 0, 0});
}

TEST_F(ApproachTest, TheSameBytesOnAnyNumberOfThreads) {
  const float farthest = 0.6f * farthest_from(mesh_, points_);
  const TriangleMesh one = near(points_, farthest, *make_tbb_backend(1, nullptr));
  for (int threads : {2, 4}) {
    const TriangleMesh other = near(points_, farthest, *make_tbb_backend(threads, nullptr));
    EXPECT_EQ(one.vertices, other.vertices);
    EXPECT_EQ(one.triangles, other.triangles);
  }
}

}  // namespace
}  // namespace vasamesh::test

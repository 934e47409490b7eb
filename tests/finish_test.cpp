/// \file
/// Finishing: a shaken surface gets its shape back; nothing else changes.

#include "stages/finish.h"

#include <gtest/gtest.h>

#include <random>

#include "stages/quality.h"
#include "stages/remesh.h"
#include "stages/sizing.h"
#include "support/analytic_lattice.h"
#include "support/invariants.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

class Finish : public ::testing::Test {
 protected:
  Finish()
      : scene_(*backend_, {36, 36, 16}, ring({18, 18, 8}, 11, 3.5f)),
        sizes_(make_sizes(*backend_, scene_.field, scene_.surface, {})) {}

  TriangleMesh remeshed() {
    return remesh(*backend_, scene_.field.view(), sizes_.view(scene_.field), scene_.surface);
  }
  TriangleMesh finished(const TriangleMesh& mesh, Backend& on) {
    return finish(on, scene_.field.view(), sizes_.view(scene_.field), mesh);
  }

  /// Moves each vertex by up to `part` along each axis.
  static TriangleMesh shaken(TriangleMesh mesh, float part) {
    std::mt19937 random(5);
    for (float& x : mesh.vertices) x += part * (static_cast<float>(random() % 2001) / 1000.0f - 1);
    return mesh;
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  AnalyticScene scene_;
  SizeField sizes_;
};

TEST_F(Finish, AShakenSurfaceGetsItsShapeBack) {
  const TriangleMesh start = remeshed(), rough = shaken(start, 0.2f);
  ASSERT_LT(measure_quality(*backend_, rough).edge_ratio_above_08, 0.7);
  const TriangleMesh mesh = finished(rough, *backend_);
  expect_good_surface(mesh, Topology{1, 1, 0});
  const QualityReport quality = measure_quality(*backend_, mesh);
  EXPECT_GE(quality.least_angle.minimum, 25);
  EXPECT_GE(quality.edge_ratio_above_08, 0.85);
  EXPECT_GE(quality.least_angle.percentile_5, 44);
  EXPECT_NEAR(static_cast<double>(mesh.triangle_count()),
              static_cast<double>(start.triangle_count()),
              0.02 * static_cast<double>(start.triangle_count()));
  EXPECT_NEAR(quality.volume, 2 * M_PI * M_PI * 11 * 3.5 * 3.5, 25);  // 1 %
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = vertex_at(mesh, v) - Vec3{18, 18, 8};
    const float across = std::sqrt(p.x * p.x + p.y * p.y) - 11;
    EXPECT_NEAR(std::sqrt(across * across + p.z * p.z), 3.5f, 0.4);
  }
}

TEST_F(Finish, AGoodSurfaceStaysGood) {
  const TriangleMesh start = remeshed(), mesh = finished(start, *backend_);
  expect_good_surface(mesh, Topology{1, 1, 0});
  EXPECT_EQ(mesh.triangle_count(), start.triangle_count());
  EXPECT_GE(measure_quality(*backend_, mesh).edge_ratio_above_08,
            measure_quality(*backend_, start).edge_ratio_above_08 - 0.02);
}

TEST_F(Finish, TheSameBytesOnAnyNumberOfThreads) {
  const TriangleMesh rough = shaken(remeshed(), 0.3f);
  const TriangleMesh one = finished(rough, *make_tbb_backend(1, nullptr));
  for (int threads : {2, 4}) {
    const TriangleMesh other = finished(rough, *make_tbb_backend(threads, nullptr));
    EXPECT_EQ(one.vertices, other.vertices);
    EXPECT_EQ(one.triangles, other.triangles);
  }
}

}  // namespace
}  // namespace vasamesh::test

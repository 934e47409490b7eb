/// \file
/// The MPU baseline and its polygonizer on shapes that are known exactly.

#include "mpu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mpu_fit.h"
#include "phantom/phantom.h"
#include "polygonizer.h"
#include "stages/distance.h"
#include "stages/quality.h"
#include "stages/verify.h"
#include "tbb/backend.h"

namespace vasamesh::baselines {
namespace {

using Eigen::Vector3d;

CheckReport check(const TriangleMesh& mesh) {
  return check_surface(*make_tbb_backend(2, nullptr), mesh, nullptr);
}

TEST(Polygonizer, ATorusIsClosedAndOutward) {
  const auto torus = [](const Vector3d& p) {
    return std::hypot(std::hypot(p[0], p[1]) - 6, p[2]) - 2.2;
  };
  const TriangleMesh mesh = polygonize(torus, {0.7, {Vector3d(6, 0, 2.2)}});
  const CheckReport report = check(mesh);
  EXPECT_TRUE(report.passed) << report.reason;
  EXPECT_EQ(report.topology, (Topology{1, 1, 0}));
  for (std::size_t v = 0; v < mesh.vertices.size(); v += 3)
    EXPECT_NEAR(torus(Vector3d(mesh.vertices[v], mesh.vertices[v + 1], mesh.vertices[v + 2])), 0,
                1e-3);
  const double volume = measure_quality(*make_tbb_backend(1, nullptr), mesh).volume;
  EXPECT_NEAR(volume, 2 * std::numbers::pi * std::numbers::pi * 6 * 2.2 * 2.2, 0.02 * volume);
}

TEST(Polygonizer, FindsWhatASeedIsNearTo) {
  const auto two = [](const Vector3d& p) {
    return std::min((p - Vector3d(-5, 0, 0)).norm(), (p - Vector3d(5, 0, 0)).norm()) - 2;
  };
  EXPECT_EQ(check(polygonize(two, {0.5, {Vector3d(-3, 0, 0)}})).topology, (Topology{1, 0, 0}));
  EXPECT_EQ(check(polygonize(two, {0.5, {Vector3d(-3, 0, 0), Vector3d(3, 0, 0)}})).topology,
            (Topology{2, 0, 0}));
  EXPECT_EQ(polygonize(two, {0.5, {Vector3d(0, 9, 0)}}).triangle_count(), 0u);
}

TEST(MpuFit, SamplesAllRoundGiveAClosedQuadric) {
  std::vector<Sample> samples;
  for (int i = 0; i < 400; ++i) {
    const double z = 1 - (2 * i + 1) / 400.0, angle = 2.4 * i, r = std::sqrt(1 - z * z);
    const Vector3d unit(r * std::cos(angle), r * std::sin(angle), z);
    samples.push_back({2 * unit, unit});
  }
  const SampleIndex index(samples);
  const Ball ball{Vector3d(0, 0, 0), 3, 1.2, index.within(Vector3d(0, 0, 0), 3)};
  ASSERT_EQ(ball.samples.size(), samples.size());
  const auto quadric = fit_ball(index, ball);
  ASSERT_TRUE(quadric);
  EXPECT_LT(quadric->value(Vector3d(0, 0, 0)), 0);
  for (const Sample& sample : samples) {
    const Vector3d gradient = quadric->gradient(sample.position);
    EXPECT_LT(std::fabs(quadric->value(sample.position)), 0.15 * gradient.norm());
    EXPECT_GT(gradient.normalized().dot(sample.normal), 0.99);
  }
}

TEST(MpuFit, AHeightFieldFitsItself) {
  std::vector<Sample> samples;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      const double x = 0.2 * i - 0.9, y = 0.2 * j - 0.9;
      samples.push_back({Vector3d(x, y, 0.1 * x * x - 0.2 * x * y + 0.05 * y),
                         Vector3d(-0.2 * x + 0.2 * y, 0.2 * x - 0.05, 1).normalized()});
    }
  const SampleIndex index(samples);
  const Ball ball{Vector3d(0, 0, 0), 2, 1, index.within(Vector3d(0, 0, 0), 2)};
  const auto quadric = fit_ball(index, ball);
  ASSERT_TRUE(quadric);
  EXPECT_GT(quadric->value(Vector3d(0, 0, 1)), 0.9);
  EXPECT_LT(quadric->value(Vector3d(0, 0, -1)), -0.9);
  for (const Sample& sample : samples) EXPECT_NEAR(quadric->value(sample.position), 0, 0.01);
}

class MpuOfPhantom : public testing::TestWithParam<const char*> {};

TEST_P(MpuOfPhantom, IsClosedAndNearTheExactSurface) {
  PhantomOptions options;
  options.exact = true;
  const Phantom phantom = make_phantom(GetParam(), options);
  const Mpu mpu(oriented_samples({phantom.geometry, phantom.voxels}), {});
  Polygonization grid;
  for (const Sample& sample : mpu.samples()) grid.seeds.push_back(sample.position);
  TriangleMesh mesh = polygonize([&](const Vector3d& p) { return mpu.value(p); }, grid);
  place_in_lps(phantom.geometry, mesh);
  const CheckReport report = check(mesh);
  EXPECT_TRUE(report.passed) << report.reason;
  EXPECT_EQ(report.topology, phantom.topology.value());
  const auto& s = phantom.geometry.spacing;
  const double voxel = std::cbrt(s[0] * s[1] * s[2]);
  const DistanceReport distance =
      measure_distance(*make_tbb_backend(2, nullptr), mesh, phantom.exact.value(), voxel);
  EXPECT_LT(distance.to.mean, 0.25 * voxel);
  EXPECT_LT(distance.back.mean, 0.25 * voxel);
}
INSTANTIATE_TEST_SUITE_P(, MpuOfPhantom, testing::Values("sphere", "torus", "y_branch"));

}  // namespace
}  // namespace vasamesh::baselines

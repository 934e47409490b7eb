/// \file
/// Surfaces of whole conversions: proven and of the segmentation's topology on every phantom, on
/// random trees and on noise; how far they lie from the exact surface and from marching cubes; and
/// the same on real scans, from the folder that VASAMESH_TEST_DATA names.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "io/marching_cubes.h"
#include "stages/distance.h"
#include "stages/quality.h"
#include "support/cases.h"
#include "support/dense_volume.h"
#include "support/invariants.h"
#include "support/scans.h"
#include "tbb/backend.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh::test {
namespace {

constexpr double kMeanOnScans = 0.17;     // voxels, to marching cubes
constexpr double kMeanOnPhantoms = 0.27;  // voxels, to marching cubes
constexpr double kMeanToExact = 0.12;     // voxels, for radii of 2.5 voxels or more
constexpr double kVolumeError = 0.02;
constexpr double kStep = 0.5;  // voxels between the samples of a distance
constexpr std::int64_t kManyPieces = 1000;
constexpr int kTrees = 100, kTreeShards = 10, kAccuracyShards = 4;

Context& context() {
  static Context shared = make_context({.backend = "tbb", .device = "", .threads = 2});
  return shared;
}

double voxel_length(const Geometry& geometry) {
  return std::cbrt(geometry.spacing[0] * geometry.spacing[1] * geometry.spacing[2]);
}

/// The largest distance to marching cubes that is allowed, in mm.
double largest_allowed(const Geometry& geometry) {
  const auto [least, most] = std::minmax_element(geometry.spacing.begin(), geometry.spacing.end());
  return std::max(*least, 0.55 * *most);
}

void expect_passed(const Result& result) {
  const CheckReport& check = result.report.check;
  EXPECT_TRUE(check.passed) << check.reason;
  EXPECT_TRUE(check.has_wanted);
  EXPECT_EQ(check.topology, check.wanted);
  EXPECT_EQ(static_cast<std::size_t>(check.triangles), result.mesh.triangle_count());
}

/// The surface is proven anew, and the report says the same of it.
void expect_proven(const Result& result, const VolumeView& volume, Connectivity connectivity) {
  expect_good_surface(result.mesh, volume, connectivity);
  expect_passed(result);
}

void expect_near_marching_cubes(const TriangleMesh& mesh, const Segmentation& segmentation,
                                double mean) {
  const double voxel = voxel_length(segmentation.geometry);
  const DistanceReport report = measure_distance(*context().backends.back(), mesh,
                                                 marching_cubes(segmentation), voxel, kStep);
  for (const OneWayDistance* way : {&report.to, &report.back}) {
    SCOPED_TRACE(way == &report.to ? "to marching cubes" : "from marching cubes");
    EXPECT_LE(way->mean, mean * voxel);
    EXPECT_LT(way->maximum, largest_allowed(segmentation.geometry));
  }
}

class SmallPhantoms : public ::testing::TestWithParam<PhantomCase> {};

TEST_P(SmallPhantoms, ProvenAndNearMarchingCubes) {
  const Phantom phantom = GetParam().make();
  const Result result = convert(phantom.view(), {}, context());
  expect_passed(result);
  if (phantom.topology) {
    EXPECT_EQ(result.report.check.topology, *phantom.topology);
  }
  if (result.report.check.topology.pieces > kManyPieces) return;  // the rest would take a minute
  expect_good_surface(result.mesh, phantom.view());
  expect_near_marching_cubes(result.mesh, {phantom.geometry, phantom.voxels}, kMeanOnPhantoms);
}

INSTANTIATE_TEST_SUITE_P(All, SmallPhantoms, ::testing::ValuesIn(small_cases()),
                         [](const auto& param_info) { return param_info.param.label; });

class Accuracy : public ::testing::TestWithParam<int> {};

TEST_P(Accuracy, NearTheExactSurfaceAndOfItsVolume) {
  const std::vector<PhantomCase> cases = accuracy_cases();
  ASSERT_GE(cases.size(), 10u);
  for (std::size_t i = static_cast<std::size_t>(GetParam()); i < cases.size();
       i += kAccuracyShards) {
    SCOPED_TRACE(cases[i].label);
    PhantomCase with_exact = cases[i];
    with_exact.options.exact = true;
    const Phantom phantom = with_exact.make();
    ASSERT_TRUE(phantom.exact);
    for (const SurfaceKind kind : {SurfaceKind::base, SurfaceKind::adaptive}) {
      Parameters parameters;
      parameters.surface = kind;
      const Result result = convert(phantom.view(), parameters, context());
      expect_proven(result, phantom.view(), Connectivity::vertex);
      const double voxel = voxel_length(phantom.geometry);
      const DistanceReport distance =
          measure_distance(*context().backends.back(), result.mesh, *phantom.exact, voxel, kStep);
      EXPECT_LE(distance.to.mean, kMeanToExact * voxel);
      EXPECT_LE(distance.back.mean, kMeanToExact * voxel);
      const double volume = measure_quality(*context().backends.back(), *phantom.exact).volume;
      EXPECT_NEAR(measure_quality(*context().backends.back(), result.mesh).volume, volume,
                  kVolumeError * volume);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shards, Accuracy, ::testing::Range(0, kAccuracyShards));

/// A coil of a tube whose slices are six times as thick as its pixels are wide: its volume over
/// that of its voxels.
TEST(ThickSlices, ThinVesselsKeepTheirVolume) {
  for (const auto& [radius, share] : {std::pair{1.5, 0.81}, {2.0, 0.91}, {3.0, 0.965}}) {
    SCOPED_TRACE(radius);
    PhantomOptions options;
    options.spacing = {0.5, 0.5, 3};
    options.radius = radius;
    const Phantom phantom = make_phantom("helix", options);
    const Result result = convert(phantom.view(), {}, context());
    expect_proven(result, phantom.view(), Connectivity::vertex);
    const double voxels = 0.75 * static_cast<double>(result.report.input.object_voxels);
    EXPECT_GE(result.report.quality.volume, share * voxels);
    EXPECT_LE(result.report.quality.volume, voxels);
  }
}

/// Labels enlarged threefold: the steps of their blocks are found, and a wide kernel smooths them.
TEST(EnlargedLabels, AreSmoothedByAWideKernel) {
  constexpr int kTimes = 3;
  const Phantom phantom = make_phantom("torus");
  const auto& size = phantom.geometry.size;
  DenseVolume small(
      {static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2])});
  small.voxels = phantom.voxels;
  const DenseVolume large = enlarged(small, {kTimes, kTimes, kTimes});
  VolumeView volume = large.view();
  for (std::size_t a = 0; a < 3; ++a)
    volume.geometry.spacing[a] = phantom.geometry.spacing[a] / kTimes;
  Parameters wide;
  wide.kernel_width = 4;
  const Result usual = convert(volume, {}, context()), smooth = convert(volume, wide, context());
  for (const Result* result : {&usual, &smooth}) {
    EXPECT_EQ(result->report.input.blocks, (std::array<std::int64_t, 3>{kTimes, kTimes, kTimes}));
    expect_proven(*result, volume, Connectivity::vertex);
    EXPECT_EQ(result->report.mesh.far_points, 0);
  }
  EXPECT_NEAR(usual.report.distance_limit, volume.geometry.spacing[0], 1e-6);
  EXPECT_NEAR(smooth.report.distance_limit, 4 / 1.66 * volume.geometry.spacing[0], 1e-6);
  EXPECT_LT(usual.report.quality.dihedral_angle.percentile_5, 150);
  EXPECT_GT(smooth.report.quality.dihedral_angle.percentile_5, 160);
  EXPECT_LT(smooth.mesh.triangle_count(), usual.mesh.triangle_count());
}

class RandomTrees : public ::testing::TestWithParam<int> {};

TEST_P(RandomTrees, Proven) {
  const std::vector<PhantomCase> cases = tree_cases(kTrees);
  for (std::size_t i = static_cast<std::size_t>(GetParam()); i < kTrees; i += kTreeShards) {
    SCOPED_TRACE(cases[i].label);
    const Phantom phantom = cases[i].make();
    const Result result = convert(phantom.view(), {}, context());
    expect_proven(result, phantom.view(), Connectivity::vertex);
  }
}

INSTANTIATE_TEST_SUITE_P(Shards, RandomTrees, ::testing::Range(0, kTreeShards));

class Noise : public ::testing::TestWithParam<Connectivity> {
 protected:
  static void convert_and_prove(const VolumeView& volume) {
    Parameters parameters;
    parameters.connectivity = GetParam();
    expect_proven(convert(volume, parameters, context()), volume, GetParam());
  }
};

TEST_P(Noise, ProvenAtAllDensities) {
  unsigned seed = 0;
  for (const double density : {0.01, 0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0}) {
    SCOPED_TRACE(density);
    const DenseVolume volume = random_volume({16, 16, 16}, density, ++seed);
    convert_and_prove(volume.view());
  }
}

TEST_P(Noise, ProvenWhereSpacingsDiffer) {
  for (const std::array<double, 3>& spacing :
       {std::array{1.0, 1.0, 3.0}, {0.3, 0.9, 0.3}, {2.5, 1.0, 0.5}}) {
    SCOPED_TRACE(::testing::Message() << spacing[0] << " " << spacing[1] << " " << spacing[2]);
    const DenseVolume volume = random_volume({13, 9, 11}, 0.4, 40);
    VolumeView view = volume.view();
    view.geometry.spacing = spacing;
    convert_and_prove(view);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Noise,
                         ::testing::Values(Connectivity::vertex, Connectivity::edge,
                                           Connectivity::face),
                         [](const auto& param_info) {
                           return "of_" + std::to_string(static_cast<int>(param_info.param));
                         });

class Scans : public ::testing::TestWithParam<const char*> {};

TEST_P(Scans, ProvenAndNearMarchingCubes) {
  const auto path = scan_path(std::string(GetParam()) + ".nii.gz");
  if (!path) GTEST_SKIP() << "VASAMESH_TEST_DATA is not set";
  const Segmentation scan = read_segmentation(*path);
  const Result result = convert(scan.view(), {}, context());
  expect_passed(result);
  expect_near_marching_cubes(result.mesh, scan, kMeanOnScans);
}

INSTANTIATE_TEST_SUITE_P(All, Scans,
                         ::testing::Values("pulmonary_arteries", "hepatic_veins", "liver_arteries",
                                           "airways", "willis_mra", "willis_roi", "aorta_mra"),
                         [](const auto& param_info) { return std::string(param_info.param); });

}  // namespace
}  // namespace vasamesh::test

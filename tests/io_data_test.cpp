/// \file
/// Real scans, from the folder that VASAMESH_TEST_DATA names: sizes, spacing, voxels.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "io/surface_io.h"
#include "io/volume_reader.h"
#include "support/scans.h"

namespace vasamesh {
namespace {

struct Scan {
  const char* name;
  std::array<std::int64_t, 3> size;
  std::array<double, 3> spacing;
  std::int64_t voxels;
};

const Scan kScans[] = {
    {"pulmonary_arteries", {512, 512, 295}, {0.6445, 0.6445, 1.0}, 264'804},
    {"hepatic_veins", {274, 172, 222}, {0.6, 0.6, 0.6}, 236'501},
    {"liver_arteries", {230, 239, 211}, {0.5, 0.5, 0.5}, 443'165},
    {"airways", {512, 512, 767}, {0.684, 0.684, 0.5}, 451'530},
    {"willis_mra", {197, 177, 122}, {0.521, 0.521, 0.65}, 23'571},
    {"willis_roi", {152, 127, 41}, {0.297, 0.297, 0.6}, 32'582},
    {"aorta_mra", {126, 349, 40}, {0.879, 0.879, 1.5}, 53'719},
};

class RealScans : public ::testing::TestWithParam<Scan> {};

TEST_P(RealScans, SizeSpacingAndVoxels) {
  const Scan& scan = GetParam();
  const auto path = test::scan_path(std::string(scan.name) + ".nii.gz");
  if (!path) GTEST_SKIP() << "VASAMESH_TEST_DATA is not set";
  const Segmentation read = read_segmentation(*path);
  EXPECT_EQ(read.geometry.size, scan.size);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(read.geometry.spacing[i], scan.spacing[i], 5e-4);
  EXPECT_EQ(std::count(read.voxels.begin(), read.voxels.end(), 1), scan.voxels);
}

INSTANTIATE_TEST_SUITE_P(All, RealScans, ::testing::ValuesIn(kScans),
                         [](const auto& param_info) { return std::string(param_info.param.name); });

// The surface that hepatic_veins was voxelised from lies where the volume is; it is in RAS.
TEST(RealSurface, LiesInItsVolume) {
  const auto surface = test::scan_path("hepatic_veins.vtk"),
             volume = test::scan_path("hepatic_veins.nii.gz");
  if (!surface) GTEST_SKIP() << "VASAMESH_TEST_DATA is not set";
  const TriangleMesh mesh = read_surface(*surface);
  const Geometry geometry = read_segmentation(*volume).geometry;
  EXPECT_GT(mesh.triangle_count(), 1000u);
  for (int axis = 0; axis < 3; ++axis) {
    const double ras = axis < 2 ? -1 : 1;
    const double a = ras * geometry.origin[axis];
    const double b = a + ras * geometry.direction[4 * axis] * geometry.spacing[axis] *
                             static_cast<double>(geometry.size[axis] - 1);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      ASSERT_GE(mesh.vertices[3 * v + axis], std::min(a, b) - 1) << axis;
      ASSERT_LE(mesh.vertices[3 * v + axis], std::max(a, b) + 1) << axis;
    }
  }
}

}  // namespace
}  // namespace vasamesh

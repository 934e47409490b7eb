/// \file
/// The reference surface of distances: where it lies, which way it faces, that it is closed.

#include "io/marching_cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "stages/bricks.h"
#include "stages/distance.h"
#include "stages/quality.h"
#include "stages/solid_surface.h"
#include "support/dense_volume.h"
#include "support/invariants.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"

namespace vasamesh::test {
namespace {

Segmentation ball(const std::array<double, 9>& direction) {
  DenseVolume volume({20, 21, 22});
  for (int z = 0; z < 22; ++z)
    for (int y = 0; y < 21; ++y)
      for (int x = 0; x < 20; ++x)
        volume.at(x, y, z) = std::hypot(x - 7.0, y - 11.0, z - 12.0) <= 6.2;
  Segmentation segmentation{volume.view().geometry, volume.voxels};
  segmentation.geometry.spacing = {0.5, 0.75, 1.25};
  segmentation.geometry.origin = {-10, 20, 30};
  segmentation.geometry.direction = direction;
  return segmentation;
}

std::array<double, 3> mean_vertex(const TriangleMesh& mesh) {
  std::array<double, 3> sum{0, 0, 0};
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) sum[i % 3] += mesh.vertices[i];
  for (double& x : sum) x /= static_cast<double>(mesh.vertex_count());
  return sum;
}

void expect_ball(const Segmentation& segmentation, const std::array<double, 3>& centre) {
  const TriangleMesh mesh = marching_cubes(segmentation);
  expect_good_surface(mesh, Topology{1, 0, 0});
  const double object =
      static_cast<double>(std::count(segmentation.voxels.begin(), segmentation.voxels.end(), 1));
  const auto backend = make_tbb_backend(2, nullptr);
  EXPECT_NEAR(measure_quality(*backend, mesh).volume / (object * 0.5 * 0.75 * 1.25), 1, 0.05);
  const std::array<double, 3> mean = mean_vertex(mesh);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(mean[a], centre[a], 1e-4);
}

TEST(MarchingCubes, LiesWhereTheVoxelsLie) {
  expect_ball(ball({1, 0, 0, 0, 1, 0, 0, 0, 1}), {-10 + 3.5, 20 + 8.25, 30 + 15});
}

TEST(MarchingCubes, TurnedAndMirroredVolumes) {
  expect_ball(ball({0, -1, 0, 1, 0, 0, 0, 0, 1}), {-10 - 8.25, 20 + 3.5, 30 + 15});
  expect_ball(ball({-1, 0, 0, 0, 1, 0, 0, 0, 1}), {-10 - 3.5, 20 + 8.25, 30 + 15});
}

/// The surfaces from the volume's whole cell lattice, in the caller's voxel units.
SolidSurface from_lattice(const DenseVolume& volume) {
  const auto backend = make_tbb_backend(2, nullptr);
  const BitVolume bits = pack_plainly(*backend, volume);
  std::vector<BrickCoord> coords;
  for (int z = 0; z < bits.size[2] / 4; ++z)
    for (int y = 0; y < bits.size[1] / 4; ++y)
      for (int x = 0; x < bits.size[0] / 4; ++x) coords.push_back({x, y, z});
  Lattice lattice;
  lattice.bricks = make_bricks(*backend, coords);
  lattice.state = Buffer<std::uint8_t>(*backend, lattice.bricks.count * kBrickCells);
  backend->lattice_label(bits.view(), 26, lattice.bricks.view(), {1, 1, 1}, lattice.state.view());
  SolidSurface surface = marching_cubes_of(*backend, lattice, {1, 1, 1});
  for (TriangleMesh* mesh : {&surface.all, &surface.common})
    for (float& x : mesh->vertices) x -= kPad + 0.5f;
  return surface;
}

std::vector<std::array<float, 3>> sorted_vertices(const TriangleMesh& mesh) {
  std::vector<std::array<float, 3>> vertices;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3)
    vertices.push_back({mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]});
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

/// VTK's surface lies between the lattice's two.
void expect_between(const DenseVolume& volume, double thickness) {
  const SolidSurface surface = from_lattice(volume);
  const TriangleMesh wanted = marching_cubes({volume.view().geometry, volume.voxels});
  EXPECT_EQ(sorted_vertices(surface.all), sorted_vertices(wanted));
  EXPECT_EQ(surface.common.vertices, surface.all.vertices);
  const auto backend = make_tbb_backend(2, nullptr);
  const DistanceReport all = measure_distance(*backend, surface.all, wanted, 1, 0.1);
  EXPECT_LT(all.back.maximum, 1e-5);
  EXPECT_LT(all.to.maximum, thickness);
  EXPECT_LT(all.to.mean, 0.2 * thickness);
  const DistanceReport common = measure_distance(*backend, surface.common, wanted, 1, 0.1);
  EXPECT_LT(common.to.maximum, 1e-5);
  EXPECT_LT(common.back.maximum, 0.65);
}

TEST(MarchingCubes, LiesBetweenTheLatticesSurfaces) {
  const Segmentation smooth = ball({1, 0, 0, 0, 1, 0, 0, 0, 1});
  DenseVolume volume({20, 21, 22});
  volume.voxels = smooth.voxels;
  expect_between(volume, 0.3);
  unsigned seed = 0;
  for (const double density : {0.02, 0.2, 0.5, 0.8, 0.97}) {
    SCOPED_TRACE(density);
    expect_between(random_volume({19, 14, 11}, density, ++seed), 0.5);
  }
}

TEST(MarchingCubes, ClosedAtTheBorder) {
  DenseVolume volume({3, 4, 5});
  volume.box({0, 0, 0}, {2, 3, 4});
  const TriangleMesh mesh = marching_cubes({volume.view().geometry, volume.voxels});
  expect_good_surface(mesh, Topology{1, 0, 0});
}

TEST(MarchingCubes, NothingInTheForeground) {
  const DenseVolume volume({3, 4, 5});
  try {
    marching_cubes({volume.view().geometry, volume.voxels});
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
  }
}

}  // namespace
}  // namespace vasamesh::test

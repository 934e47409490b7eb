/// \file
/// Distances between surfaces: closed forms, and the nearest of all triangles one by one.

#include "stages/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"
#include "vasamesh/errors.h"

namespace vasamesh::test {
namespace {

DistanceReport measure(const TriangleMesh& a, const TriangleMesh& b, double voxel = 1,
                       double step = 0.25, int threads = 2) {
  return measure_distance(*make_tbb_backend(threads, nullptr), a, b, voxel, step);
}

TEST(Distance, ASurfaceToItselfIsZero) {
  const TriangleMesh mesh = torus(5, 2, 31, 17);
  const DistanceReport d = measure(mesh, mesh);
  EXPECT_LT(d.to.maximum, 1e-6);
  EXPECT_EQ(d.to.maximum, d.back.maximum);
}

TEST(Distance, ConcentricSpheres) {
  const DistanceReport d = measure(sphere(5, 5), sphere(4, 5));
  for (const OneWayDistance& way : {d.to, d.back}) {
    EXPECT_NEAR(way.mean, 1, 2e-3);
    EXPECT_NEAR(way.rms, 1, 2e-3);
    EXPECT_NEAR(way.maximum, 1, 4e-3);
  }
}

/// From the lower square to the upper one, a unit above and half as wide: the height over the inner
/// part, more beyond it. From the upper to the lower it is 1 everywhere.
TEST(Distance, BothWaysDiffer) {
  const auto square = [](float half, float z) {
    TriangleMesh mesh;
    for (const Vertex& p :
         {Vertex{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}})
      add_vertex(mesh, p);
    add_triangle(mesh, 0, 1, 2);
    add_triangle(mesh, 0, 2, 3);
    return mesh;
  };
  const DistanceReport d = measure(square(2, 0), square(1, 1), 1, 0.02);
  EXPECT_NEAR(d.back.mean, 1, 1e-6);
  EXPECT_NEAR(d.back.maximum, 1, 1e-6);
  EXPECT_NEAR(d.to.maximum, std::sqrt(3.0), 1e-6);
  // The square's mean of 1 + dx^2 + dy^2, d = max(0, |x| - 1): 1 + 2 * (1/2) * (1/3).
  EXPECT_NEAR(d.to.rms, std::sqrt(1 + 1.0 / 3), 1e-3);
}

TEST(Distance, VerticesCountForTheMaximum) {
  TriangleMesh spiked = box({0, 0, 0}, {1, 1, 1});
  const std::uint32_t tip = add_vertex(spiked, {0.5f, 0.5f, 3});
  for (std::size_t i = spiked.triangles.size() - 6; i < spiked.triangles.size(); i += 3)
    spiked.triangles[i + 2] = tip;
  EXPECT_NEAR(measure(spiked, box({0, 0, 0}, {1, 1, 1}), 1, 10).to.maximum, 2, 1e-6);
}

/// The distance of a point to a triangle by a fine search over it.
double plain_distance(const float* p, const TriangleMesh& mesh) {
  constexpr int kCuts = 160;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (int i = 0; i <= kCuts; ++i)
      for (int j = 0; i + j <= kCuts; ++j) {
        const double w[3] = {double(i) / kCuts, double(j) / kCuts, double(kCuts - i - j) / kCuts};
        double sum = 0;
        for (int a = 0; a < 3; ++a) {
          double x = -p[a];
          for (int k = 0; k < 3; ++k) x += w[k] * mesh.vertices[3 * mesh.triangles[3 * t + k] + a];
          sum += x * x;
        }
        least = std::min(least, sum);
      }
  return std::sqrt(least);
}

TEST(Distance, NearestPointAsSearchedPlainly) {
  const TriangleMesh coarse = torus(5, 2, 7, 5);
  TriangleMesh probe;  // triangles so small that each is a point
  for (int i = 0; i < 24; ++i) {
    probe.vertices.clear();
    probe.triangles.clear();
    const auto x = static_cast<float>(i);
    const Vertex p{9 * std::sin(1.7f * x), 8 * std::cos(2.3f * x), 4 * std::sin(0.9f * x + 1)};
    for (const Vertex& by : {Vertex{0, 0, 0}, {1e-5f, 0, 0}, {0, 1e-5f, 0}})
      add_vertex(probe, {p[0] + by[0], p[1] + by[1], p[2] + by[2]});
    add_triangle(probe, 0, 1, 2);
    EXPECT_NEAR(measure(probe, coarse, 1, 1).to.mean, plain_distance(p.data(), coarse), 0.02) << i;
  }
}

TEST(Distance, OfPointsAsSearchedPlainlyInAnyOrder) {
  const TriangleMesh coarse = torus(5, 2, 7, 5);
  std::vector<Vec3> points = {{coarse.vertices[0], coarse.vertices[1], coarse.vertices[2]}};
  for (int i = 0; i < 30; ++i) {
    const auto x = static_cast<float>(i);
    points.push_back({9 * std::sin(1.7f * x), 8 * std::cos(2.3f * x), 4 * std::sin(0.9f * x + 1)});
  }
  const auto distances = [&](int threads) {
    const auto backend = make_tbb_backend(threads, nullptr);
    return distances_to(*backend, points, coarse, build_triangle_tree(*backend, coarse));
  };
  std::vector<float> forth = distances(2);
  ASSERT_EQ(forth.size(), points.size());
  EXPECT_EQ(forth, distances(1));
  EXPECT_LT(forth[0], 1e-5);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(forth[i], plain_distance(&points[i].x, coarse), 0.02) << i;
  std::reverse(points.begin(), points.end());
  std::reverse(forth.begin(), forth.end());
  const std::vector<float> back = distances(2);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(back[i], forth[i], 1e-5) << i;
}

TEST(Distance, StepIsInVoxelsAndLengthsInMillimetres) {
  const DistanceReport d = measure(sphere(5, 3), sphere(4, 3), 0.5);
  EXPECT_EQ(d.voxel, 0.5);
  EXPECT_NEAR(d.to.mean, 1, 0.03);
}

TEST(Distance, SameForAnyNumberOfThreads) {
  const TriangleMesh a = torus(5, 2, 61, 37), b = moved(torus(5, 2.1f, 50, 30), {0.1f, 0.2f, 0});
  const DistanceReport one = measure(a, b, 1, 0.25, 1), two = measure(a, b, 1, 0.25, 2);
  EXPECT_EQ(one.to.mean, two.to.mean);
  EXPECT_EQ(one.back.rms, two.back.rms);
  EXPECT_EQ(one.to.maximum, two.to.maximum);
}

TEST(Distance, RefusesWhatHasNoDistance) {
  TriangleMesh broken = tetrahedron();
  broken.vertices[4] = std::numeric_limits<float>::quiet_NaN();
  for (const TriangleMesh& mesh : {TriangleMesh{}, broken}) {
    EXPECT_THROW(measure(mesh, tetrahedron()), Error);
    EXPECT_THROW(measure(tetrahedron(), mesh), Error);
  }
  EXPECT_THROW(measure(tetrahedron(), tetrahedron(), 0), Error);
}

}  // namespace
}  // namespace vasamesh::test

/// \file
/// Quality figures on shapes whose figures are known.

#include "stages/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

QualityReport measure(const TriangleMesh& mesh, int threads = 2) {
  return measure_quality(*make_tbb_backend(threads, nullptr), mesh);
}

TEST(Quality, UnitBox) {
  const QualityReport q = measure(box({0, 0, 0}, {1, 1, 1}));
  EXPECT_NEAR(q.edge_ratio.mean, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(q.edge_ratio.deviation, 0, 1e-6);
  EXPECT_NEAR(q.least_angle.minimum, 45, 1e-5);
  EXPECT_NEAR(q.least_angle.maximum, 45, 1e-5);
  EXPECT_EQ(q.edge_length.minimum, 1);
  EXPECT_NEAR(q.edge_length.mean, (12 + 6 * std::sqrt(2.0)) / 18, 1e-6);
  EXPECT_NEAR(q.edge_length.maximum, std::sqrt(2.0), 1e-6);
  EXPECT_EQ(q.size_ratio.mean, 1);
  EXPECT_DOUBLE_EQ(q.area, 6);
  EXPECT_DOUBLE_EQ(q.volume, 1);
  EXPECT_EQ(q.edge_ratio_above_08, 0);
  EXPECT_EQ(q.edge_ratio_below_03, 0);
}

TEST(Quality, IcosahedronIsEquilateral) {
  const QualityReport q = measure(sphere(1, 0));
  EXPECT_NEAR(q.edge_ratio.minimum, 1, 1e-6);
  EXPECT_NEAR(q.least_angle.median, 60, 1e-4);
  EXPECT_EQ(q.edge_ratio_above_08, 1);
  EXPECT_EQ(q.edges_within_15, 1);
  EXPECT_NEAR(q.area, 5 * std::sqrt(3.0) / std::pow(std::sin(0.4 * std::numbers::pi), 2), 1e-5);
}

TEST(Quality, InsideOutHasNegativeVolume) {
  EXPECT_DOUBLE_EQ(measure(turned_inside_out(box({4, 5, 6}, {6, 6, 7}))).volume, -2);
  EXPECT_NEAR(measure(moved(sphere(3, 5), {1000, -500, 20})).volume, 36 * std::numbers::pi, 0.2);
}

TEST(Quality, SizeRatioOfNeighbours) {
  // Edges 1, 1, sqrt 2 and 3, sqrt 10, 1: they share one of length 1.
  TriangleMesh mesh;
  for (const Vertex& p : {Vertex{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -3, 0}}) add_vertex(mesh, p);
  add_triangle(mesh, 0, 1, 2);
  add_triangle(mesh, 1, 0, 3);
  const QualityReport q = measure(mesh);
  const double wanted = (4 + std::sqrt(10.0)) / (2 + std::sqrt(2.0));
  EXPECT_NEAR(q.size_ratio.minimum, wanted, 1e-6);
  EXPECT_NEAR(q.size_ratio.maximum, wanted, 1e-6);
  EXPECT_EQ(q.edge_length.minimum, 1);
  EXPECT_EQ(q.edge_length.maximum, 1);
  EXPECT_EQ(q.edge_ratio_below_03, 0);
  EXPECT_NEAR(q.edge_ratio.minimum, 1 / std::sqrt(10.0), 1e-6);
  EXPECT_DOUBLE_EQ(q.edges_within_15, 4.0 / 6);  // all pairs but 1 with 3 and sqrt 10
}

TEST(Quality, DihedralAnglesOfSolids) {
  // Twelve edges of a cube, and the diagonals of its six faces.
  const QualityReport cube = measure(box({0, 0, 0}, {1, 1, 1}));
  EXPECT_NEAR(cube.dihedral_angle.minimum, 90, 1e-4);
  EXPECT_NEAR(cube.dihedral_angle.mean, (12 * 90 + 6 * 180) / 18.0, 1e-4);
  EXPECT_EQ(cube.sharp_edges, 0);
  // It is the same from inside.
  EXPECT_NEAR(measure(turned_inside_out(box({0, 0, 0}, {1, 1, 1}))).dihedral_angle.minimum, 90,
              1e-4);
  const QualityReport icosahedron = measure(sphere(1, 0));
  EXPECT_NEAR(icosahedron.dihedral_angle.minimum, 138.1897, 1e-3);
  EXPECT_NEAR(icosahedron.dihedral_angle.maximum, 138.1897, 1e-3);
}

TEST(Quality, SharpEdgesAreBelow60Degrees) {
  // A roof of two triangles, its eaves 2 apart: 60 degrees are 1.732 up.
  for (const float height : {0.0f, 1.7f, 1.8f, 10.0f}) {
    TriangleMesh roof;
    for (const Vertex& p : {Vertex{0, 0, 0}, {2, 0, 0}, {1, height, -1}, {1, height, 1}})
      add_vertex(roof, p);
    add_triangle(roof, 0, 1, 2);
    add_triangle(roof, 1, 0, 3);
    const QualityReport q = measure(roof);
    EXPECT_EQ(q.sharp_edges, height > 1.732f ? 1 : 0) << height;
    EXPECT_NEAR(q.dihedral_angle.mean, 2 * std::atan2(1.0, height) * 180 / std::numbers::pi, 1e-4);
  }
}

TEST(Quality, DegenerateAndEmpty) {
  TriangleMesh mesh;
  add_vertex(mesh, {1, 1, 1});
  add_triangle(mesh, 0, 0, 0);
  EXPECT_EQ(measure(mesh).edge_ratio.mean, 0);
  EXPECT_EQ(measure(mesh).edge_ratio_below_01, 1);
  EXPECT_EQ(measure(mesh).edges_within_15, 0);
  EXPECT_EQ(measure(TriangleMesh{}).area, 0);
}

TEST(Quality, PercentilesAreRanks) {
  std::vector<float> values(1013);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  std::shuffle(values.begin(), values.end(), std::mt19937(4));
  const Distribution d = describe(*make_tbb_backend(2, nullptr), values);
  EXPECT_EQ(d.minimum, 0);
  EXPECT_EQ(d.percentile_5, 50);  // rank ceil(50.65) = 51
  EXPECT_EQ(d.median, 506);
  EXPECT_EQ(d.percentile_95, 962);  // rank ceil(962.35) = 963
  EXPECT_EQ(d.maximum, 1012);
  EXPECT_DOUBLE_EQ(d.mean, 506);
  EXPECT_NEAR(d.deviation, std::sqrt((1013.0 * 1013 - 1) / 12), 1e-6);
}

TEST(Quality, WeightsCountAsRepeatedValues) {
  const std::vector<float> values = {3, 1, 2, 9, 1.5f}, weights = {40, 30, 20, 0, 10};
  std::vector<float> repeated;
  for (std::size_t i = 0; i < values.size(); ++i)
    repeated.insert(repeated.end(), static_cast<std::size_t>(weights[i]), values[i]);
  const Distribution plain = describe(*make_tbb_backend(2, nullptr), repeated),
                     weighted = describe_weighted(values, weights);
  EXPECT_NEAR(weighted.mean, plain.mean, 1e-12);
  EXPECT_NEAR(weighted.deviation, plain.deviation, 1e-12);
  EXPECT_EQ(weighted.minimum, 1);
  EXPECT_EQ(weighted.percentile_5, plain.percentile_5);
  EXPECT_EQ(weighted.median, plain.median);
  EXPECT_EQ(weighted.median, 2);
  EXPECT_EQ(weighted.percentile_95, plain.percentile_95);
  EXPECT_EQ(weighted.maximum, 3);  // 9 has no weight
  EXPECT_EQ(describe_weighted({5}, {0}).maximum, 0);
}

TEST(Quality, ShapesOneByOne) {
  const auto backend = make_tbb_backend(1, nullptr);
  TriangleMesh mesh = tetrahedron();
  const TriangleShapes shapes = triangle_shapes(*backend, mesh);
  ASSERT_EQ(shapes.edge_ratio.size(), 4u);
  EXPECT_NEAR(shapes.edge_ratio[0], std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(shapes.edge_ratio[3], 1, 1e-6);
  EXPECT_NEAR(shapes.least_angle[0], 45, 1e-4);
  EXPECT_NEAR(shapes.least_angle[3], 60, 1e-4);
  EXPECT_NEAR(shapes.mean_edge[3], std::sqrt(2.0), 1e-6);
}

TEST(Quality, SameForAnyNumberOfThreads) {
  const TriangleMesh mesh = torus(5, 2, 301, 199);
  const QualityReport one = measure(mesh, 1), two = measure(mesh, 2);
  EXPECT_EQ(one.area, two.area);
  EXPECT_EQ(one.volume, two.volume);
  EXPECT_EQ(one.size_ratio.mean, two.size_ratio.mean);
  EXPECT_EQ(one.least_angle.percentile_5, two.least_angle.percentile_5);
}

}  // namespace
}  // namespace vasamesh::test

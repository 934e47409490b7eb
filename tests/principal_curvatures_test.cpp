/// \file
/// Principal curvatures where a closed form gives them.

#include "stages/principal_curvatures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "stages/quality.h"
#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

constexpr double kPi = std::numbers::pi;

PrincipalCurvatures measure(const TriangleMesh& mesh, int threads = 2) {
  return principal_curvatures(*make_tbb_backend(threads, nullptr), mesh);
}

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Round the z axis, open at both ends; n vertices round it, m rings. The rings are moved along and
/// round by random parts of a step, so that no direction is that of an edge.
TriangleMesh cylinder(float radius, float height, int n, int m) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(-0.25, 0.25);
  TriangleMesh mesh;
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      const double angle = 2 * kPi * (j + part(random)) / n;
      const double z = height * (i + (i > 0 && i + 1 < m ? part(random) : 0)) / (m - 1);
      add_vertex(mesh, {radius * static_cast<float>(std::cos(angle)),
                        radius * static_cast<float>(std::sin(angle)), static_cast<float>(z)});
    }
  for (int i = 0; i + 1 < m; ++i)
    for (int j = 0; j < n; ++j) {
      const auto at = [&](int a, int b) { return static_cast<std::uint32_t>(a * n + b % n); };
      add_triangle(mesh, at(i, j), at(i, j + 1), at(i + 1, j + 1));
      add_triangle(mesh, at(i, j), at(i + 1, j + 1), at(i + 1, j));
    }
  return mesh;
}

TEST(PrincipalCurvatures, OfASphere) {
  const TriangleMesh mesh = sphere(2.5f, 3);
  const PrincipalCurvatures found = measure(mesh);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(found.most[v], 0.4, 0.01) << v;
    EXPECT_NEAR(found.least[v], 0.4, 0.01) << v;
    EXPECT_NEAR(found.rms()[v], 0.4, 0.01) << v;
  }
  EXPECT_NEAR(mean(measure(turned_inside_out(mesh)).most), -0.4, 0.01);
}

TEST(PrincipalCurvatures, OfACylinder) {
  constexpr int kRound = 24, kRings = 31;
  const PrincipalCurvatures found = measure(cylinder(3, 20, kRound, kRings));
  double most = 0, least = 0, count = 0;
  for (int v = 3 * kRound; v < (kRings - 3) * kRound; ++v, ++count)  // far from the open ends
    most += std::fabs(found.most[v] * 3 - 1), least += std::fabs(found.least[v] * 3);
  EXPECT_LT(most / count, 0.1);
  EXPECT_LT(least / count, 0.1);
}

/// kmax = 1 / r, kmin = cos v / (R + r cos v) at the angle v round the tube.
TEST(PrincipalCurvatures, OfATorus) {
  constexpr int kAlong = 90, kRound = 30;
  const double large = 6, small = 2;
  const TriangleMesh mesh = torus(large, small, kAlong, kRound);
  const PrincipalCurvatures found = measure(mesh);
  double most = 0, least = 0, rms = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double cosine = std::cos(2 * kPi * static_cast<double>(v % kRound) / kRound);
    const double k1 = 1 / small, k2 = cosine / (large + small * cosine);
    most += std::fabs(found.most[v] / k1 - 1);
    least += std::fabs(found.least[v] - k2) * small;
    rms += std::fabs(found.rms()[v] / std::sqrt(0.5 * (k1 * k1 + k2 * k2)) - 1);
  }
  const auto count = static_cast<double>(mesh.vertex_count());
  EXPECT_LT(most / count, 0.03);
  EXPECT_LT(least / count, 0.03);
  EXPECT_LT(rms / count, 0.03);
}

TEST(PrincipalCurvatures, AreasAddUpAndWeighTheMean) {
  const TriangleMesh mesh = torus(6, 2, 90, 30);
  const PrincipalCurvatures found = measure(mesh);
  double area = 0, gauss = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    area += found.area[v];
    gauss += found.area[v] * found.most[v] * found.least[v];
  }
  EXPECT_NEAR(area, 4 * kPi * kPi * 6 * 2, 0.01 * area);
  EXPECT_NEAR(gauss, 0, 0.3);  // 4 pi (1 - genus)
}

TEST(PrincipalCurvatures, NoAreaNoCurvature) {
  TriangleMesh mesh = sphere(2, 1);
  const std::uint32_t lone = add_vertex(mesh, {9, 9, 9});
  add_triangle(mesh, lone, lone, 0);
  const PrincipalCurvatures found = measure(mesh);
  EXPECT_EQ(found.rms()[lone], 0);
  EXPECT_EQ(found.area[lone], 0);
  for (const float k : found.rms()) EXPECT_TRUE(std::isfinite(k));
}

TEST(PrincipalCurvatures, SameForAnyNumberOfThreads) {
  const TriangleMesh mesh = torus(5, 2, 301, 199);
  EXPECT_EQ(measure(mesh, 1).most, measure(mesh, 3).most);
  EXPECT_EQ(measure(mesh, 1).least, measure(mesh, 3).least);
}

}  // namespace
}  // namespace vasamesh::test

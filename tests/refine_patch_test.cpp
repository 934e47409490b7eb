/// \file
/// Patches refined by themselves: the rim stays, the density comes, the triangles are good.

#include "stages/refine_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "stages/triangulate_gap.h"
#include "support/analytic_field.h"

namespace vasamesh::test {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

AnalyticField& ball() {
  static AnalyticField field = sphere_field(24, {12, 12, 12}, 8);
  return field;
}

Vec3 outward(const Vec3& p) { return normalised(p - Vec3{12, 12, 12}); }

/// Corners round the top of the ball, `angle` (radians) from its pole, moved by up to `rough` of
/// that; triangulated as gaps are.
Patch cap(int corners, double angle, double rough, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return random() * 0x1p-31 - 1; };
  Patch patch;
  for (int i = 0; i < corners; ++i) {
    const double turn = 2 * std::numbers::pi * (i + 0.3 * rough * uniform()) / corners;
    const double tilt = angle * (1 + rough * uniform());
    patch.points.push_back({static_cast<float>(12 + 8 * std::sin(tilt) * std::cos(turn)),
                            static_cast<float>(12 + 8 * std::sin(tilt) * std::sin(turn)),
                            static_cast<float>(12 + 8 * std::cos(tilt))});
    patch.normals.push_back(outward(patch.points.back()));
  }
  const std::vector<std::uint8_t> chords(patch.points.size() * patch.points.size(), 1);
  GapTriangulator triangulator;
  EXPECT_TRUE(triangulator.run({patch.points, patch.normals, patch.normals, chords},
                               {ball().view()}, StitchMode::exact));
  patch.triangles.assign(triangulator.triangles().begin(), triangulator.triangles().end());
  patch.rim = patch.points.size();
  return patch;
}

float worst(const Patch& patch) {
  float worst = 0;
  for (std::size_t t = 0; t < patch.triangles.size(); t += 3)
    worst = std::max(worst, least_angle_measure(patch.points[patch.triangles[t]],
                                                patch.points[patch.triangles[t + 1]],
                                                patch.points[patch.triangles[t + 2]]));
  return worst;
}

/// A disc with that rim, every triangle facing outward, new vertices on the ball; no edge between
/// corners that was not there before.
void expect_sound(const Patch& patch, const Patch& before) {
  ASSERT_TRUE(std::equal(before.points.begin(), before.points.end(), patch.points.begin()));
  const auto n = static_cast<std::uint32_t>(patch.rim);
  std::map<Edge, int> edges, old_edges;
  for (std::size_t c = 0; c < patch.triangles.size(); ++c)
    ++edges[{patch.triangles[c], patch.triangles[c % 3 == 2 ? c - 2 : c + 1]}];
  for (std::size_t c = 0; c < before.triangles.size(); ++c)
    ++old_edges[{before.triangles[c], before.triangles[c % 3 == 2 ? c - 2 : c + 1]}];
  std::size_t rim = 0;
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    const bool is_rim = edge.first < n && edge.second == (edge.first + 1) % n;
    EXPECT_EQ(edges.contains({edge.second, edge.first}), !is_rim);
    if (edge.first < n && edge.second < n) {
      EXPECT_TRUE(old_edges.contains(edge));
    }
    rim += is_rim;
  }
  EXPECT_EQ(rim, patch.rim);
  const std::size_t undirected = (edges.size() + rim) / 2;
  EXPECT_EQ(patch.points.size() + patch.triangles.size() / 3, undirected + 1);
  for (std::size_t t = 0; t < patch.triangles.size(); t += 3) {
    const Vec3 &a = patch.points[patch.triangles[t]], &b = patch.points[patch.triangles[t + 1]],
               &c = patch.points[patch.triangles[t + 2]];
    EXPECT_GT(dot(cross(b - a, c - a), outward(a + b + c - Vec3{24, 24, 24})), 0);
  }
  for (std::size_t v = patch.rim; v < patch.points.size(); ++v)
    EXPECT_NEAR(norm(patch.points[v] - Vec3{12, 12, 12}), 8, 0.02);
}

TEST(RefinePatch, OneTriangleIsLeft) {
  Patch patch = cap(3, 0.1, 0, 1);
  const Patch before = patch;
  PatchRefiner(ball().view(), ball().sizes(0.1f)).run(patch);
  EXPECT_EQ(patch.triangles, before.triangles);
  EXPECT_EQ(patch.points, before.points);
}

TEST(RefinePatch, ShortEdgesAreLeft) {
  Patch patch = cap(4, 0.1, 0, 1);  // a square of 1.13
  const Patch before = patch;
  PatchRefiner(ball().view(), ball().sizes(1.8f)).run(patch);
  EXPECT_EQ(patch.triangles, before.triangles);
}

TEST(RefinePatch, AHexagonGetsItsMiddle) {
  Patch patch = cap(6, 0.125, 0, 1);  // edges of 1
  PatchRefiner(ball().view(), ball().sizes(1)).run(patch);
  ASSERT_EQ(patch.points.size(), 7u);
  EXPECT_EQ(patch.triangles.size(), 18u);
  EXPECT_LT(norm(patch.points[6] - Vec3{12, 12, 20}), 0.05f);
}

class RoughCaps : public ::testing::TestWithParam<unsigned> {};

TEST_P(RoughCaps, ComeToTheDensityAskedFor) {
  const int corners = 8 + 4 * static_cast<int>(GetParam() % 8);
  const double angle = corners / (2 * std::numbers::pi * 8);  // edges of about 1
  Patch patch = cap(corners, angle, 0.15, GetParam());
  const Patch before = patch;
  PatchRefiner refiner(ball().view(), ball().sizes(1));
  refiner.run(patch);
  expect_sound(patch, before);
  EXPECT_LT(worst(patch), worst(before));
  float longest = 0;
  for (std::size_t c = 0; c < patch.triangles.size(); ++c) {
    const std::uint32_t a = patch.triangles[c], b = patch.triangles[c % 3 == 2 ? c - 2 : c + 1];
    if (std::max(a, b) >= patch.rim)
      longest = std::max(longest, norm(patch.points[b] - patch.points[a]));
  }
  EXPECT_LT(longest, 1.6f);
  // As many triangles as edges of one length give for the cap's area.
  const double area = 2 * std::numbers::pi * 64 * (1 - std::cos(angle));
  EXPECT_NEAR(static_cast<double>(patch.triangles.size()) / 3 / (area / 0.433), 1, 0.35);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoughCaps, ::testing::Range(0u, 24u));

TEST(RefinePatch, SameAfterAnotherPatch) {
  PatchRefiner refiner(ball().view(), ball().sizes(1)), fresh(ball().view(), ball().sizes(1));
  Patch other = cap(30, 0.6, 0.1, 5), patch = cap(12, 0.25, 0.1, 6), again = patch;
  refiner.run(other);
  refiner.run(patch);
  fresh.run(again);
  EXPECT_EQ(patch.points, again.points);
  EXPECT_EQ(patch.triangles, again.triangles);
}

TEST(RefinePatch, OffTheFieldNothingIsAdded) {
  AnalyticField elsewhere = sphere_field(12, {6, 6, 6}, 3);
  Patch patch = cap(10, 0.3, 0, 2);
  const Patch before = patch;
  PatchRefiner(elsewhere.view(), elsewhere.sizes(1)).run(patch);
  EXPECT_EQ(patch.points, before.points);
  EXPECT_EQ(patch.triangles, before.triangles);
}

}  // namespace
}  // namespace vasamesh::test

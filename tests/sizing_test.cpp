/// \file
/// Sizes of edges: radii of curvature of known shapes, the clamps, the gradation against a plain
/// shortest-way search, and the triangles that are predicted.

#include "stages/sizing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "support/analytic_lattice.h"
#include "support/backend_test.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {
namespace {

Backend& backend(int threads = 2) {
  static const std::shared_ptr<Backend> backends[] = {make_tbb_backend(1, nullptr),
                                                      make_tbb_backend(2, nullptr)};
  return *backends[threads - 1];
}

struct Radii {
  float low, median, high;  ///< 5th percentile, median, 95th
};

Radii radii_of(const AnalyticScene& scene, const std::function<bool(const Vec3&)>& where) {
  const SizeField sizes = make_sizes(backend(), scene.field, scene.surface, {});
  std::vector<float> radii;
  for (std::size_t i = 0; i < sizes.samples.count(); ++i)
    if (where(sizes.samples.position[i])) radii.push_back(sizes.samples.radius[i]);
  std::sort(radii.begin(), radii.end());
  return {radii[radii.size() / 20], radii[radii.size() / 2], radii[radii.size() * 19 / 20]};
}

TEST(Sizing, RadiusOfSpheres) {
  for (const float radius : {2.0f, 4.0f, 8.0f}) {
    const AnalyticScene scene(backend(), {24, 24, 24}, ball({12.1f, 11.8f, 12.3f}, radius));
    const Radii radii = radii_of(scene, [](const Vec3&) { return true; });
    EXPECT_NEAR(radii.median, radius, 0.04f * radius);
    EXPECT_GT(radii.low, 0.9f * radius);
    EXPECT_LT(radii.high, 1.1f * radius);
  }
}

/// Radii that are known to be ample at a short distance are not sought for at longer ones.
TEST(Sizing, AmpleRadiiNeedNotBeRight) {
  for (const float radius : {2.0f, 8.0f}) {
    const AnalyticScene scene(backend(), {24, 24, 24}, ball({12.1f, 11.8f, 12.3f}, radius));
    const float ample = ample_radius({});
    EXPECT_FLOAT_EQ(ample, 4);
    const SizeField all = make_sizes(backend(), scene.field, scene.surface, {});
    const SizeField made = make_sizes(backend(), scene.field, scene.surface, {}, ample);
    EXPECT_EQ(all.samples.radius == made.samples.radius, radius < ample);
    for (const float found : made.samples.radius) EXPECT_NEAR(found, radius, 0.2f * radius);
    for (std::size_t i = 0; i < all.sizes.size(); ++i)
      ASSERT_EQ(all.sizes.view()[i], made.sizes.view()[i]);
  }
}

TEST(Sizing, TheAmpleRadiusGoesByTheRule) {
  EXPECT_FLOAT_EQ(ample_radius({.rho = 0.5f, .edge_max = 3}), 1.5f * 3 / 0.5f);
  EXPECT_FLOAT_EQ(ample_radius({.chord_error = 0.05f, .edge_max = 2}), 1.5f * 4 / (8 * 0.05f));
  EXPECT_FLOAT_EQ(ample_radius({.rho = 2, .edge_max = 2}), 1.5f * 2 / 1.25f);
  EXPECT_EQ(ample_radius({.rho = 1e-9f, .edge_max = 2}), kLargestRadius);
}

TEST(Sizing, RadiusOfObliqueTubesIsThatAcross) {
  for (const float radius : {1.0f, 2.0f, 4.0f}) {
    const AnalyticScene scene(backend(), {32, 24, 24}, capsule({6, 10, 11}, {26, 13, 14}, radius));
    const Radii radii = radii_of(scene, [](const Vec3& p) { return p.x > 10 && p.x < 22; });
    EXPECT_NEAR(radii.median, radius, 0.1f * radius);
    EXPECT_GT(radii.low, 0.8f * radius);
    EXPECT_LT(radii.high, 1.3f * radius);
  }
}

TEST(Sizing, VoxelsNeedNotBeCubes) {
  const Scale scale = {0.8f, 0.8f, 1.5625f};
  const AnalyticScene scene(backend(), {32, 32, 16}, ball({12.5f, 12.5f, 12.5f}, 5), scale);
  EXPECT_NEAR(radii_of(scene, [](const Vec3&) { return true; }).median, 5, 0.25);
}

TEST(Sizing, ClampedAndNeverMuchMoreThanTheRadius) {
  const AnalyticScene scene(
      backend(), {48, 24, 24},
      joined({ball({12, 12, 12}, 8), capsule({12, 12, 12}, {40, 12, 12}, 0.7f)}, 0.5f));
  const SizeField sizes = make_sizes(backend(), scene.field, scene.surface, {});
  const SizeView view = sizes.view(scene.field);
  EXPECT_FLOAT_EQ(size_at(view, {4, 12, 12}), 1.6f);
  EXPECT_NEAR(size_at(view, {34, 12.7f, 12}), 1.25f * 0.7f, 0.12f);
  EXPECT_FLOAT_EQ(size_at(view, {-3, 12, 12}), 1.6f);  // outside every brick
}

TEST(Sizing, AShellThatTheFunctionDoesNotShowHasEdgesOfItsSize) {
  AnalyticScene scene(backend(), {24, 24, 24}, ball({12, 12, 12}, 8));
  TriangleMesh cavity = moved(turned_inside_out(sphere(0.3, 1)), {15, 13, 12});
  const TriangleMesh both = joined(scene.surface, cavity);
  const SizeField without = make_sizes(backend(), scene.field, scene.surface, {});
  const SizeField with = make_sizes(backend(), scene.field, both, {});
  const Vec3 at = vertex_at(cavity, 0);
  EXPECT_FLOAT_EQ(size_at(without.view(scene.field), at), 1.6f);
  EXPECT_NEAR(size_at(with.view(scene.field), at), 1.25f * 0.3f, 0.01f);
  EXPECT_FLOAT_EQ(size_at(with.view(scene.field), {4, 12, 12}), 1.6f);
}

/// Values that no step between neighbours can lower, found by trying all until nothing changes.
std::vector<float> settled(std::vector<float> values, const std::array<int, 3>& cells,
                           const Scale& scale, float growth) {
  const auto index = [&](int x, int y, int z) {
    const int brick = (x >> 2) + cells[0] / 4 * ((y >> 2) + cells[1] / 4 * (z >> 2));
    return static_cast<std::size_t>(64 * brick + (x & 3) + 4 * (y & 3) + 16 * (z & 3));
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (int z = 0; z < cells[2]; ++z)
      for (int y = 0; y < cells[1]; ++y)
        for (int x = 0; x < cells[0]; ++x)
          for (int n = 0; n < 27; ++n) {
            const int i = x + n % 3 - 1, j = y + n / 3 % 3 - 1, k = z + n / 9 - 1;
            if (i < 0 || j < 0 || k < 0 || i >= cells[0] || j >= cells[1] || k >= cells[2])
              continue;
            const float step =
                norm({scale[0] * static_cast<float>(i - x), scale[1] * static_cast<float>(j - y),
                      scale[2] * static_cast<float>(k - z)});
            const float most = values[index(i, j, k)] + growth * step;
            if (most < values[index(x, y, z)] - 1e-5f) {
              values[index(x, y, z)] = most;
              changed = true;
            }
          }
  }
  return values;
}

TEST(Sizing, GrowthIsLimitedAsByTryingAllSteps) {
  const Scale scale = {0.8f, 0.8f, 1.5625f};
  const std::array<int, 3> size = {20, 12, 8};
  const IndicatorField field = make_field(
      backend(), analytic_lattice(backend(), size, scale, [](const Vec3&) { return 1.0f; }), size,
      scale);
  Buffer<float> values(backend(), 64 * field.brick_count());
  std::vector<float> given(values.size(), 3.0f);
  std::mt19937 random(4);
  for (int i = 0; i < 9; ++i) given[random() % given.size()] = 0.5f + 0.1f * static_cast<float>(i);
  backend().upload<float>(values.view(), given);
  grow_limited(backend(), field, 0.25f, values);
  const std::vector<float> want = settled(given, size, scale, 0.25f);
  int lowered = 0;
  for (std::size_t i = 0; i < want.size(); ++i) {
    ASSERT_NEAR(values.view()[i], want[i], 1e-4) << i;
    lowered += want[i] < given[i];
  }
  EXPECT_GT(lowered, 1000);
}

TEST(Sizing, PredictsTheTrianglesOfASphere) {
  const AnalyticScene scene(backend(), {24, 24, 24}, ball({12, 12, 12}, 8));
  for (const float edge : {0.8f, 1.3f}) {
    const SizeField sizes =
        make_sizes(backend(), scene.field, scene.surface, {.edge_min = edge, .edge_max = edge});
    const double want = 4 * std::numbers::pi * 64 / (std::sqrt(3.0) / 4 * edge * edge);
    EXPECT_NEAR(sizes.predicted_triangles, want, 0.02 * want);
  }
}

/// The sizes of the cells whose sample lies in a ball, in ascending order.
std::vector<float> sizes_within(const SizeField& sizes, const Vec3& centre, float radius) {
  std::vector<float> found;
  for (std::size_t i = 0; i < sizes.samples.count(); ++i)
    if (norm(sizes.samples.position[i] - centre) < radius)
      found.push_back(sizes.sizes.view()[sizes.samples.cell[i]]);
  std::sort(found.begin(), found.end());
  EXPECT_GT(found.size(), 5u);
  return found;
}

TEST(Sizing, ByTheHeightOfAnEdgesArc) {
  const AnalyticScene scene(backend(), {24, 24, 24}, ball({12, 12, 12}, 6));
  for (const float height : {0.02f, 0.05f}) {
    const SizeField sizes =
        make_sizes(backend(), scene.field, scene.surface,
                   {.rho = 0.01f, .chord_error = height, .edge_min = 0.1f, .edge_max = 10});
    const float want = std::sqrt(8 * height * 6);
    const std::vector<float> found = sizes_within(sizes, {12, 12, 12}, 8);
    EXPECT_NEAR(found[found.size() / 2], want, 0.05f * want);
  }
}

TEST(Sizing, AnotherRuleFromTheSameRadii) {
  const AnalyticScene scene(backend(), {40, 40, 40}, random_tree(3, 4, 40));
  const SizeRule rule = {.rho = 0.4f, .edge_min = 0.6f, .edge_max = 2.5f};
  const SizeField made = make_sizes(backend(), scene.field, scene.surface, rule);
  SizeField changed = make_sizes(backend(), scene.field, scene.surface, {});
  EXPECT_NE(changed.predicted_triangles, made.predicted_triangles);
  apply_rule(backend(), scene.field, scene.surface, rule, {}, changed);
  EXPECT_EQ(changed.predicted_triangles, made.predicted_triangles);
  for (std::size_t i = 0; i < made.sizes.size(); ++i)
    ASSERT_EQ(changed.sizes.view()[i], made.sizes.view()[i]) << i;
}

TEST(Sizing, ShorterInPlacesByTheLeastFactorButNotUnderTheLimit) {
  const AnalyticScene scene(backend(), {40, 24, 24}, capsule({8, 12, 12}, {32, 12, 12}, 7));
  SizeField sizes = make_sizes(backend(), scene.field, scene.surface, {});
  const double whole = sizes.predicted_triangles;
  const Vec3 in_two{14, 19, 12}, in_zero{20, 5, 12}, beyond{32, 19, 12};
  const auto expect_size = [&](const Vec3& centre, float want) {
    for (const float size : sizes_within(sizes, centre, 2)) EXPECT_FLOAT_EQ(size, want);
  };
  const float most = SizeRule{}.edge_max;
  for (const Vec3& centre : {in_two, in_zero, beyond}) expect_size(centre, most);
  const CarefulPlace places[] = {{in_two, 2, 0.7f}, {in_two, 2, 0.5f}, {in_zero, 2, 0}};
  apply_rule(backend(), scene.field, scene.surface, {}, places, sizes);
  expect_size(in_two, 0.5f * most);
  expect_size(in_zero, 0.4f * most);
  expect_size(beyond, most);
  EXPECT_GT(sizes.predicted_triangles, whole);
  apply_rule(backend(), scene.field, scene.surface, {}, {}, sizes);
  expect_size(in_two, most);
  EXPECT_EQ(sizes.predicted_triangles, whole);
}

TEST(Sizing, SameForAnyNumberOfThreads) {
  const AnalyticScene scene(backend(), {40, 40, 40}, random_tree(3, 4, 40));
  const SizeField one = make_sizes(backend(1), scene.field, scene.surface, {});
  const SizeField two = make_sizes(backend(2), scene.field, scene.surface, {});
  EXPECT_EQ(one.predicted_triangles, two.predicted_triangles);
  EXPECT_EQ(one.samples.radius, two.samples.radius);
  for (std::size_t i = 0; i < one.sizes.size(); ++i)
    ASSERT_EQ(one.sizes.view()[i], two.sizes.view()[i]);
}

/// The pass on every backend, over a field that lies in another backend's memory.
class SizingPass : public BackendTest {
 protected:
  void expect_as_one_by_one(float ample) {
    const AnalyticScene scene(test::backend(), {32, 24, 24},
                              capsule({6, 10, 11}, {26, 13, 14}, 2.5f));
    const FieldView field = scene.field.view();
    std::mt19937 random(4);
    std::vector<Vec3> points;
    for (std::size_t v = 0; v < scene.surface.vertex_count(); v += 7) {
      const auto shift = [&] { return static_cast<float>(random() % 1000) * 0.0006f - 0.3f; };
      points.push_back(vertex_at(scene.surface, v) + Vec3{shift(), shift(), shift()});
    }
    points.push_back({16, 12, 12});   // too deep
    points.push_back({-3, 2, 1e9f});  // outside
    auto positions = to_backend(BackendTest::backend(), points);
    auto normals = to_backend(BackendTest::backend(), std::vector<Vec3>(points.size(), {7, 7, 7}));
    auto radii = to_backend(BackendTest::backend(), std::vector<float>(points.size(), 7));
    BackendTest::backend().sizing_measure(field, ample, positions.view(), normals.view(),
                                          radii.view());
    const auto at = to_host(BackendTest::backend(), positions.view());
    const auto normal = to_host(BackendTest::backend(), normals.view());
    const auto radius = to_host(BackendTest::backend(), radii.view());
    std::size_t found = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec3 p = points[i];
      const FieldSample sample = project_to_surface(field, kSampleReach, kSampleSteps, p);
      found += sample.known;
      const Vec3 outward = sample.known ? -normalised(sample.gradient) : Vec3{};
      ASSERT_EQ(at[i], sample.known ? p : points[i]) << i;
      ASSERT_EQ(normal[i], outward) << i;
      ASSERT_EQ(radius[i], sample.known ? radius_of_curvature(field, p, outward, ample) : 0.0f)
          << i;
    }
    EXPECT_GT(found, 100u);
    EXPECT_LE(found, points.size() - 2);
  }
};

TEST_P(SizingPass, MeasuresAsTheFunctionsForOnePointDo) {
  for (const float ample : {kLargestRadius, 2.0f}) {
    SCOPED_TRACE(ample);
    expect_as_one_by_one(ample);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, SizingPass, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh::test

/// \file
/// The indicator function of the mesh stages: the spline as summed directly, its gradient, what it
/// reproduces, and the way onto its zero set.

#include "stages/field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/analytic_lattice.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

const Scale kOblong = {0.8f, 0.8f, 1.5625f};

Backend& backend() {
  static const std::shared_ptr<Backend> tbb = make_tbb_backend(2, nullptr);
  return *tbb;
}

Solid3 noise(unsigned seed) {
  auto random = std::make_shared<std::mt19937>(seed);
  return [random](const Vec3&) { return static_cast<float>((*random)() % 2001) / 1000.0f - 1.0f; };
}

double quadratic_spline(double t) {
  t = std::abs(t);
  if (t <= 0.5) return 0.75 - t * t;
  return t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
}

/// A lattice's values and coefficients, one node at a time.
struct Nodes {
  Nodes(const Lattice& lattice, const std::array<int, 3>& size) {
    for (std::size_t i = 0; i < 3; ++i) count[i] = 2 * size[i];
    values.assign(static_cast<std::size_t>(count[0]) * count[1] * count[2], NAN);
    const BrickView bricks = lattice.bricks.view();
    for (std::size_t b = 0; b < bricks.count; ++b)
      for (int c = 0; c < kBrickCells; ++c) {
        const BrickCoord& at = bricks.coords[b];
        values[index(8 * at.x + c % 8, 8 * at.y + c / 8 % 8, 8 * at.z + c / 64)] =
            lattice.values.view()[kBrickCells * b + static_cast<std::size_t>(c)];
      }
  }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * count[1] + y) * count[0] + x;
  }
  double value(int x, int y, int z) const {
    const bool in = x >= 0 && y >= 0 && z >= 0 && x < count[0] && y < count[1] && z < count[2];
    return in ? values[index(x, y, z)] : NAN;
  }
  double coefficient(int x, int y, int z) const {
    double c = value(x, y, z);
    for (const auto& e : {std::array{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      const double low = value(x - e[0], y - e[1], z - e[2]);
      const double high = value(x + e[0], y + e[1], z + e[2]);
      if (!std::isnan(low) && !std::isnan(high)) c -= (low + high - 2 * value(x, y, z)) / 8;
    }
    return c;
  }
  /// The spline by its definition; not a number where a node that counts is not there.
  double spline(const double (&at)[3]) const {
    double sum = 0;
    const int mid[3] = {int(std::lround(at[0])), int(std::lround(at[1])), int(std::lround(at[2]))};
    for (int z = mid[2] - 1; z <= mid[2] + 1; ++z)
      for (int y = mid[1] - 1; y <= mid[1] + 1; ++y)
        for (int x = mid[0] - 1; x <= mid[0] + 1; ++x)
          sum += coefficient(x, y, z) * quadratic_spline(at[0] - x) * quadratic_spline(at[1] - y) *
                 quadratic_spline(at[2] - z);
    return sum;
  }
  std::array<int, 3> count;
  std::vector<double> values;
};

TEST(Field, ValueAsSummedDirectlyAndUnknownWhereABrickIsMissing) {
  const std::array<int, 3> size = {12, 8, 16};
  const Lattice lattice =
      analytic_lattice(backend(), size, kOblong, noise(5),
                       [](const BrickCoord& c) { return c.x != 1 || c.y != 0 || c.z != 2; });
  const IndicatorField field = make_field(backend(), lattice, size, kOblong);
  const Nodes nodes(lattice, size);
  std::mt19937 random(6);
  int known = 0, unknown = 0;
  for (int i = 0; i < 4000; ++i) {
    Vec3 p;
    float* axes[3] = {&p.x, &p.y, &p.z};
    double at[3];
    for (std::size_t a = 0; a < 3; ++a) {
      const auto range = static_cast<unsigned>(1000 * size[a]);
      *axes[a] = kOblong[a] * static_cast<float>(random() % range) / 1000.0f;
      at[a] = double{*axes[a]} / (0.5 * double{kOblong[a]});
    }
    const FieldSample sample = sample_field(field.view(), p);
    const double want = nodes.spline(at);
    if (!sample.known) {
      ++unknown;
      const bool inside =
          at[0] >= 1 && at[0] < 22 && at[1] >= 1 && at[1] < 14 && at[2] >= 1 && at[2] < 30;
      EXPECT_TRUE(std::isnan(want) || !inside) << at[0] << " " << at[1] << " " << at[2];
      continue;
    }
    ++known;
    ASSERT_NEAR(sample.value, want, 1e-5);
  }
  EXPECT_GT(known, 1500);
  EXPECT_GT(unknown, 300);
}

TEST(Field, GradientAsDifferencesOfTheValue) {
  const Lattice lattice = analytic_lattice(backend(), {8, 8, 8}, kOblong, noise(7));
  const IndicatorField owner = make_field(backend(), lattice, {8, 8, 8}, kOblong);
  std::mt19937 random(8);
  const auto coordinate = [&](int a) {
    return kOblong[static_cast<std::size_t>(a)] * (1 + static_cast<float>(random() % 5000) / 1000);
  };
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = {coordinate(0), coordinate(1), coordinate(2)};
    const FieldSample sample = sample_field(owner.view(), p);
    ASSERT_TRUE(sample.known);
    const auto slope = [&](const Vec3& step) {
      return (sample_field(owner.view(), p + step).value -
              sample_field(owner.view(), p - step).value) /
             (2 * norm(step));
    };
    constexpr float kStep = 2e-3f;
    EXPECT_NEAR(sample.gradient.x, slope({kStep, 0, 0}), 0.02);
    EXPECT_NEAR(sample.gradient.y, slope({0, kStep, 0}), 0.02);
    EXPECT_NEAR(sample.gradient.z, slope({0, 0, kStep}), 0.02);
  }
}

TEST(Field, ReproducesQuadraticFunctions) {
  const auto f = [](const Vec3& p) {
    return 0.3f + 0.2f * p.x - 0.1f * p.y * p.z + 0.05f * p.x * p.x - 0.07f * p.z * p.z;
  };
  const IndicatorField field = make_field(
      backend(), analytic_lattice(backend(), {12, 12, 12}, kOblong, f), {12, 12, 12}, kOblong);
  for (int i = 0; i < 200; ++i) {
    const auto t = static_cast<float>(i);
    const Vec3 p = {2 + 0.03f * t, 8 - 0.028f * t, 4 + 0.045f * t};
    const FieldSample sample = sample_field(field.view(), p);
    ASSERT_TRUE(sample.known);
    EXPECT_NEAR(sample.value, f(p), 2e-4);
    EXPECT_NEAR(sample.gradient.x, 0.2f + 0.1f * p.x, 1e-3);
    EXPECT_NEAR(sample.gradient.z, -0.1f * p.y - 0.14f * p.z, 1e-3);
  }
}

TEST(Field, ProjectionComesOntoASphere) {
  const Vec3 centre = {12, 12, 12};
  const AnalyticScene scene(backend(), {24, 24, 24}, ball(centre, 6));
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const auto part = [&] { return static_cast<float>(random() % 2001) / 1000.0f - 1.0f; };
    const Vec3 direction = normalised(Vec3{part(), part(), part()});
    const float off = 0.8f * part();
    Vec3 p = centre + (6 + off) * direction;
    const Vec3 start = p;
    const FieldSample at = project_to_surface(scene.field.view(), 1, 6, p);
    ASSERT_TRUE(at.known);
    EXPECT_NEAR(norm(p - centre), 6, 0.02);
    EXPECT_LT(dot(at.gradient, direction), -0.9f);
    if (std::fabs(off) > 0.2f) {
      Vec3 q = start;
      EXPECT_FALSE(project_to_surface(scene.field.view(), 0.5f * std::fabs(off), 6, q).known);
    }
  }
}

}  // namespace
}  // namespace vasamesh::test

/// \file
/// The indicator function: splatting against eq. 4 summed directly, the transfer between levels,
/// the conjugate gradient against a dense solution, and the field of a ball.

#include "stages/poisson.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "reference/octree_reference.h"
#include "stages/bricks.h"
#include "stages/normals.h"
#include "stages/points.h"
#include "support/backend_test.h"
#include "support/brick_sets.h"
#include "support/cases.h"
#include "support/dense_volume.h"
#include "tbb/backend.h"

namespace vasamesh {
namespace {

using reference::Position;
using reference::SplineField;
using test::DenseVolume;

class IndicatorFunction : public ::testing::Test {
 protected:
  IndicatorFunction() { context_.backends = {backend_}; }

  void sample(const VolumeView& volume) {
    object_ = pack_volume(*backend_, volume);
    scale_ = make_scale(volume.geometry);
    points_ = extract_points(*backend_, object_, scale_);
    estimate_normals(*backend_, object_, scale_, {}, points_);
    octree_ = build_octree(*backend_, points_, scale_, {});
  }

  /// Moves the samples within their voxels and gives them areas and thicknesses of their own.
  void scatter_samples(std::uint32_t seed) {
    const std::vector<float> random = random_floats(7 * points_.count, seed);
    for (std::size_t i = 0; i < points_.count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float& at = points_.position[axis].view()[i];
        at = std::clamp(at + 0.2f * random[7 * i + axis], std::floor(at), std::floor(at) + 0.99f);
        points_.area[axis].view()[i] = random[7 * i + 3 + axis];
      }
      points_.thickness.view()[i] = 0.5f + 0.5f * random[7 * i + 6];
    }
  }

  std::vector<float> splat(int exponent, const Kernel& kernel) {
    OctreeLevel& level = octree_.at_exponent(exponent);
    backend_->poisson_splat(level.view(), index_points(*backend_, level, points_).view(),
                            points_.view(), scale_, kernel, level.right_hand_side.view());
    return to_host(*backend_, level.right_hand_side.view());
  }

  SplineField field(int exponent) {
    const OctreeLevel& level = octree_.at_exponent(exponent);
    return {exponent, level.coords, to_host<const float>(*backend_, level.solution.view())};
  }

  /// The field of the finest level whose splines reach a position.
  double value_at(const Position& position) {
    for (std::size_t i = octree_.levels.size(); i-- > 0;) {
      const SplineField spline = field(octree_.levels[i].exponent);
      if (spline.covers(position)) return spline.at(position);
    }
    return 0;
  }

  void solve() {
    Scheduler scheduler(context_);
    assemble_poisson(*backend_, points_, scale_, {}, octree_);
    solve_poisson(scheduler, {}, octree_, reports_);
  }

  std::shared_ptr<Backend> backend_ = make_tbb_backend(2, nullptr);
  Context context_;
  BitVolume object_;
  PointCloud points_;
  Scale scale_{1, 1, 1};
  Octree octree_;
  std::vector<LevelReport> reports_;
};

TEST_F(IndicatorFunction, SplatIsTheDirectSum) {
  const DenseVolume volume = test::random_volume({14, 7, 6}, 0.02, 6).box({1, 1, 1}, {4, 4, 4});
  for (const std::array<double, 3>& spacing : {std::array{1.0, 1.0, 1.0}, {0.7, 0.8, 1.9}}) {
    VolumeView view = volume.view();
    view.geometry.spacing = spacing;
    sample(view);
    scatter_samples(3);
    ASSERT_TRUE(octree_.has_refined());
    for (const Kernel& kernel : {Kernel{0.75f, 1.66f}, Kernel{0.5f, 2.5f}})
      for (const int exponent : {0, -1}) {
        SCOPED_TRACE(::testing::Message() << spacing[2] << " " << kernel.thick << " " << exponent);
        const std::vector<float> got = splat(exponent, kernel);
        const OctreeLevel& level = octree_.at_exponent(exponent);
        double largest = 0;
        for (std::size_t i = 0; i < got.size(); i += 11) {  // not a divisor of a brick's side
          const BrickCoord b = level.coords[i / kBrickCells];
          const int c = static_cast<int>(i % kBrickCells);
          const double want =
              reference::splatted(points_.view(), scale_, kernel, exponent,
                                  {8 * b.x + c % 8, 8 * b.y + c / 8 % 8, 8 * b.z + c / 64});
          ASSERT_NEAR(got[i], want, 2e-5) << i;
          largest = std::max(largest, std::abs(want));
        }
        EXPECT_GT(largest, 0.1);
      }
  }
}

TEST_F(IndicatorFunction, RightHandSideOfEachLevelSumsToNothing) {
  sample(tree_cases(3).back().make().view());
  assemble_poisson(*backend_, points_, scale_, {}, octree_);
  for (const OctreeLevel& level : octree_.levels) {
    if (level.exponent < 0) continue;  // the refined level holds the thin vessels alone
    double sum = 0, magnitude = 0;
    for (const float b : to_host<const float>(*backend_, level.right_hand_side.view())) {
      sum += b;
      magnitude += std::abs(b);
    }
    EXPECT_GT(magnitude, 1);
    EXPECT_LT(std::abs(sum), 1e-6 * magnitude) << "exponent " << level.exponent;
  }
}

double dot(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i]) * b[i];
  return sum;
}

/// Windows of the other level's bricks round each brick, as the passes want them.
Buffer<std::int32_t> windows(Backend& backend, const std::vector<BrickCoord>& bricks, int side,
                             const auto& corner, const std::vector<BrickCoord>& others) {
  std::vector<BrickCoord> corners;
  for (const BrickCoord& b : bricks) corners.push_back({corner(b.x), corner(b.y), corner(b.z)});
  return brick_windows(backend, corners, side, others);
}

class Transfer : public BackendTest {
 protected:
  void SetUp() override {
    BackendTest::SetUp();
    if (::testing::Test::IsSkipped()) return;
    coarse_bricks_ = make_bricks(backend(), coarse_);
    fine_bricks_ = make_bricks(backend(), fine_);
  }

  std::vector<float> prolong(const std::vector<float>& values) {
    const auto parents = windows(
        backend(), fine_, 3, [](int c) { return (c >> 1) - 1; }, coarse_);
    const auto from = to_backend(backend(), values);
    Buffer<float> to(backend(), fine_.size() * kBrickCells);
    backend().poisson_prolong({-1, fine_bricks_.view(), {1, 1, 1}}, parents.view(), from.view(),
                              to.view());
    return to_host(backend(), to.view());
  }
  std::vector<float> restrict_from(const std::vector<float>& values) {
    const auto children = windows(
        backend(), coarse_, 4, [](int c) { return 2 * c - 1; }, fine_);
    const auto from = to_backend(backend(), values);
    Buffer<float> to(backend(), coarse_.size() * kBrickCells);
    backend().poisson_restrict({0, coarse_bricks_.view(), {1, 1, 1}}, children.view(), from.view(),
                               to.view());
    return to_host(backend(), to.view());
  }

  std::vector<BrickCoord> coarse_ = random_bricks(20, 4), fine_ = random_bricks(90, 5);
  Bricks coarse_bricks_, fine_bricks_;
};

TEST_P(Transfer, RestrictionIsTheTransposeOfProlongation) {
  const auto coarse = random_floats(coarse_.size() * kBrickCells, 1);
  const auto fine = random_floats(fine_.size() * kBrickCells, 2);
  const double one = dot(fine, prolong(coarse)), other = dot(restrict_from(fine), coarse);
  EXPECT_GT(std::abs(one), 1);
  EXPECT_NEAR(one, other, 1e-5 * std::sqrt(dot(fine, fine) * dot(coarse, coarse)));
}

TEST_P(Transfer, ProlongationKeepsTheSpline) {
  const auto values = random_floats(coarse_.size() * kBrickCells, 7);
  const SplineField coarse(0, coarse_, values), fine(-1, fine_, prolong(values));
  std::mt19937 random(9);
  const auto part = [&] { return static_cast<double>(random()) / 4294967296.0; };
  int compared = 0;
  for (const BrickCoord& b : fine_)
    for (int i = 0; i < 60; ++i) {
      const Position at = {4 * (b.x + part()), 4 * (b.y + part()), 4 * (b.z + part())};
      if (!coarse.covers(at) || !fine.covers(at)) continue;
      ASSERT_NEAR(fine.at(at), coarse.at(at), 1e-6);
      ++compared;
    }
  EXPECT_GT(compared, 300);
}

INSTANTIATE_TEST_SUITE_P(Backends, Transfer, ::testing::ValuesIn(backend_names()), test_name);

TEST_F(IndicatorFunction, SamplesHaveTheSplinesValue) {
  const DenseVolume volume = test::random_volume({14, 7, 6}, 0.02, 6).box({1, 1, 1}, {4, 4, 4});
  sample(volume.view());
  for (const int exponent : {0, -1}) {
    OctreeLevel& level = octree_.at_exponent(exponent);
    backend_->upload<float>(level.solution.view(), random_floats(level.solution.size(), 3));
    Buffer<float> values(*backend_, points_.count);
    backend_->fill(values.view(), 77.0f);
    backend_->poisson_sample_points(level.view(), index_points(*backend_, level, points_).view(),
                                    points_.view(), level.solution.view(), values.view());
    const SplineField spline = field(exponent);
    const PointView points = points_.view();
    std::size_t sampled = 0;
    for (std::size_t i = 0; i < points.count; ++i) {
      const float value = values.view()[i];
      if (exponent < 0 && value == 77.0f) continue;
      ++sampled;
      ASSERT_NEAR(value,
                  spline.at({points.position[0][i], points.position[1][i], points.position[2][i]}),
                  1e-5)
          << i;
    }
    EXPECT_GT(sampled, points.count / 4);
  }
}

/// The conjugate gradient on every backend.
class ConjugateGradient : public BackendTest {};

TEST_P(ConjugateGradient, ReachesTheDenseSolution) {
  const std::vector<BrickCoord> coords = {{0, 0, 0}, {1, 0, 0}};
  const Bricks bricks = make_bricks(backend(), coords);
  const LevelView level{0, bricks.view(), {1.3f, 0.8f, 0.9f}};
  const std::size_t n = 2 * kBrickCells;
  const std::vector<std::uint8_t> unknown = random_mask(n, 3);
  const std::vector<float> b = random_floats(n, 4), start = random_floats(n, 5);

  // Rows of known cells hold them where they are.
  const auto cell = [](int x, int y, int z) {
    return kBrickCells * (x >> 3) + brick_cell(x & 7, y, z);
  };
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd right(n);
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 16; ++x) {
        const int i = cell(x, y, z);
        right[i] = unknown[i] ? b[i] : start[i];
        if (!unknown[i]) continue;
        a(i, i) = 0;
        for (int axis = 0; axis < 3; ++axis) {
          a(i, i) += 2 * level.weights[axis];
          for (const int step : {-1, 1}) {
            const int u = x + (axis == 0) * step, v = y + (axis == 1) * step,
                      w = z + (axis == 2) * step;
            if (u < 0 || v < 0 || w < 0 || u > 15 || v > 7 || w > 7) continue;
            a(i, cell(u, v, w)) -= level.weights[axis];
          }
        }
      }
  const Eigen::VectorXd want = a.partialPivLu().solve(right);

  const auto mask = to_backend(backend(), unknown);
  const auto right_hand_side = to_backend(backend(), b);
  auto x = to_backend(backend(), start);
  SolveWorkspace workspace;
  const SolveOutcome outcome = conjugate_gradient(backend(), level, mask.view(),
                                                  right_hand_side.view(), x.view(), 200, workspace);
  EXPECT_LT(outcome.iterations, 200);
  EXPECT_LT(outcome.residual, 2e-6);
  EXPECT_GT(outcome.initial_residual, 0.1);
  const std::vector<float> got = to_host(backend(), x.view());
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_NEAR(got[i], want[static_cast<Eigen::Index>(i)], 1e-4) << i;
    if (!unknown[i]) {
      ASSERT_EQ(got[i], start[i]);
    }
  }
}

TEST_P(ConjugateGradient, NothingToDo) {
  const Bricks bricks = make_bricks(backend(), std::vector<BrickCoord>{{0, 0, 0}});
  const LevelView level{0, bricks.view(), {1, 1, 1}};
  const auto mask = to_backend(backend(), std::vector<std::uint8_t>(kBrickCells, 1));
  const auto zero = to_backend(backend(), std::vector<float>(kBrickCells, 0));
  auto x = to_backend(backend(), std::vector<float>(kBrickCells, 0));
  SolveWorkspace workspace;
  const SolveOutcome outcome =
      conjugate_gradient(backend(), level, mask.view(), zero.view(), x.view(), 10, workspace);
  EXPECT_EQ(outcome.iterations, 0);
  EXPECT_EQ(outcome.residual, 0);
  EXPECT_EQ(to_host(backend(), x.view()), std::vector<float>(kBrickCells, 0));
}

INSTANTIATE_TEST_SUITE_P(Backends, ConjugateGradient, ::testing::ValuesIn(backend_names()),
                         test_name);

DenseVolume ball(int size, double radius) {
  DenseVolume volume({size, size, size});
  const double centre = 0.5 * (size - 1);
  for (int z = 0; z < size; ++z)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        volume.at(x, y, z) = std::hypot(x - centre, y - centre, z - centre) < radius;
  return volume;
}

TEST_F(IndicatorFunction, OneInsideABallAndZeroOutside) {
  const DenseVolume volume = ball(27, 10.4);
  sample(volume.view());
  solve();
  const double centre = kPad + 13.5;
  const auto at = [&](double radius, int direction) {
    const double step =
        radius / std::sqrt((direction & 1) + (direction >> 1 & 1) + (direction >> 2 & 1));
    return value_at({centre + step * (direction & 1), centre - step * (direction >> 1 & 1),
                     centre + step * (direction >> 2 & 1)});
  };
  for (int direction = 1; direction < 8; ++direction) {
    SCOPED_TRACE(direction);
    for (const double radius : {0.0, 3.0, 7.0}) EXPECT_NEAR(at(radius, direction), 1, 0.06);
    for (const double radius : {14.0, 16.0, 19.0}) EXPECT_NEAR(at(radius, direction), 0, 0.06);
    EXPECT_NEAR(at(10.4, direction), 0.5, 0.15);
  }
  ASSERT_EQ(reports_.size(), octree_.levels.size());
  for (const LevelReport& report : reports_) {
    EXPECT_LE(report.iterations, std::max(kRootIterations, kLevelIterations));
    EXPECT_LT(report.residual, 0.5 * report.initial_residual);
  }
}

TEST_F(IndicatorFunction, FieldAtTheSamplesAveragesToZero) {
  sample(tree_cases(3).back().make().view());
  solve();
  const auto mean = [&] {
    Buffer<float> values(*backend_, points_.count);
    for (const int exponent : {0, -1}) {
      OctreeLevel& level = octree_.at_exponent(exponent);
      backend_->poisson_sample_points(level.view(), index_points(*backend_, level, points_).view(),
                                      points_.view(), level.solution.view(), values.view());
    }
    double sum = 0, weight = 0;
    const PointView p = points_.view();
    for (std::size_t i = 0; i < p.count; ++i) {
      const double area = std::hypot(p.area[0][i], p.area[1][i], p.area[2][i]);
      sum += area * values.view()[i];
      weight += area;
    }
    return sum / weight;
  };
  EXPECT_NEAR(mean(), 0.5, 0.2);
  subtract_isovalue(*backend_, points_, scale_, octree_);
  EXPECT_NEAR(mean(), -kOutwardBias, 0.01);
}

// A lattice of struts one voxel wide: the middles of the struts and the branchings lie on the zero
// set alike, so that neither is a thread and neither swells.
TEST_F(IndicatorFunction, ThinVesselsKeepTheirWidthBetweenBranchings) {
  DenseVolume volume({27, 27, 27});
  for (const int i : {5, 13, 21})
    for (const int j : {5, 13, 21})
      volume.box({5, i, j}, {21, i, j}).box({i, 5, j}, {i, 21, j}).box({i, j, 5}, {i, j, 21});
  sample(volume.view());
  solve();
  subtract_isovalue(*backend_, points_, scale_, octree_);
  const SplineField refined = field(-1);
  const PointView p = points_.view();
  std::array<double, 2> sum{}, count{};
  for (std::size_t i = 0; i < p.count; ++i) {
    const Position at = {p.position[0][i], p.position[1][i], p.position[2][i]};
    double farthest = 0;  // from the nearest branching, along a strut
    for (const double a : at)
      farthest = std::max(farthest, std::fabs(std::remainder(a - (kPad + 5.5), 8)));
    if (farthest > 1.6 && farthest < 3) continue;
    const std::size_t kind = farthest < 2 ? 0 : 1;
    sum[kind] += refined.at(at);
    ++count[kind];
  }
  ASSERT_GT(count[0], 100);
  ASSERT_GT(count[1], 100);
  EXPECT_NEAR(sum[0] / count[0], 0, 0.05);
  EXPECT_NEAR(sum[1] / count[1], 0, 0.05);
}

TEST_F(IndicatorFunction, IsovalueIsTheWeightedMean) {
  const DenseVolume volume = ball(17, 6.3);
  sample(volume.view());
  const OctreeLevel& level = octree_.at_exponent(1);
  const std::vector<float> at_points = random_floats(points_.count, 2);
  std::vector<float> of_points = random_floats(points_.count, 3);
  for (std::size_t i = 0; i < of_points.size(); ++i)
    of_points[i] = i % 5 == 0 ? 0 : std::fabs(of_points[i]);
  const auto values = to_backend(*backend_, at_points);
  const auto point_weights = to_backend(*backend_, of_points);
  const std::size_t cells = level.coords.size() * kBrickCells;
  Buffer<float> mean(*backend_, cells), weight(*backend_, cells);
  backend_->isovalue_splat(level.view(), index_points(*backend_, level, points_).view(),
                           points_.view(), point_weights.view(), values.view(), mean.view(),
                           weight.view());
  const PointView p = points_.view();
  for (std::size_t i = 0; i < cells; i += 7) {
    const BrickCoord b = level.coords[i / kBrickCells];
    const int c = static_cast<int>(i % kBrickCells);
    const double cell[3] = {8.0 * b.x + c % 8, 8.0 * b.y + c / 8 % 8, 8.0 * b.z + c / 64};
    double numerator = 0, denominator = 0;
    for (std::size_t k = 0; k < p.count; ++k) {
      double w = of_points[k];
      for (std::size_t axis = 0; axis < 3; ++axis)
        w *= reference::bspline(p.position[axis][k] / 2 - cell[axis] - 0.5);
      numerator += w * at_points[k];
      denominator += w;
    }
    ASSERT_NEAR(mean.view()[i], numerator, 1e-5) << i;
    ASSERT_NEAR(weight.view()[i], denominator, 1e-5) << i;
  }
  const auto weights = to_host(*backend_, weight.view()), before = to_host(*backend_, mean.view());
  backend_->isovalue_divide(0.25f, weight.view(), mean.view());
  for (std::size_t i = 0; i < cells; ++i)
    ASSERT_NEAR(mean.view()[i], (before[i] + 1e-4 * 0.25) / (weights[i] + 1e-4), 1e-4) << i;
}

TEST_F(IndicatorFunction, IsovalueSmoothsAlongOneAxis) {
  const std::vector<BrickCoord> coords = random_bricks(30, 6);
  const Bricks bricks = make_bricks(*backend_, coords);
  const std::vector<float> values = random_floats(coords.size() * kBrickCells, 8);
  const auto in = to_backend(*backend_, values);
  Buffer<float> out(*backend_, values.size());
  const auto at = [&](std::array<int, 3> cell) {
    const auto found = std::find(coords.begin(), coords.end(),
                                 BrickCoord{cell[0] >> 3, cell[1] >> 3, cell[2] >> 3});
    if (found == coords.end()) return 0.0;
    return static_cast<double>(
        values[kBrickCells * static_cast<std::size_t>(found - coords.begin()) +
               static_cast<std::size_t>(brick_cell(cell[0] & 7, cell[1] & 7, cell[2] & 7))]);
  };
  for (int axis = 0; axis < 3; ++axis) {
    backend_->isovalue_smooth({0, bricks.view(), {1, 1, 1}}, axis, 0.21f, in.view(), out.view());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const BrickCoord b = coords[i / kBrickCells];
      const int c = static_cast<int>(i % kBrickCells);
      std::array<int, 3> low = {8 * b.x + c % 8, 8 * b.y + c / 8 % 8, 8 * b.z + c / 64}, high = low;
      --low[static_cast<std::size_t>(axis)];
      ++high[static_cast<std::size_t>(axis)];
      ASSERT_NEAR(out.view()[i], 0.58 * values[i] + 0.21 * (at(low) + at(high)), 1e-6);
    }
  }
}

}  // namespace
}  // namespace vasamesh

#include "stages/poisson.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "backend/in_steps.h"
#include "stages/bricks.h"

namespace vasamesh {

namespace {

std::size_t cells(const OctreeLevel& level) { return level.bricks.count * kBrickCells; }

/// The exponent of the finest level that is solved; finer ones only represent its field.
int finest_solved(const Octree& octree, const Parameters& parameters) {
  const int regular_depth = octree.depth(octree.at_exponent(0));
  return parameters.depth == 0 ? octree.levels.back().exponent : regular_depth - parameters.depth;
}

/// The splatting kernels, no narrower than the finest cells where these are larger than voxels.
Kernel kernel_of(Scale scale, const Parameters& parameters, int finest) {
  std::sort(scale.begin(), scale.end());
  const float fine = std::min(scale[1] / kFineSpacing, 1.0f);
  const float least = finest > 0 ? std::ldexp(1.0f, finest) : 0.0f;
  const auto thick = static_cast<float>(parameters.kernel_width);
  return {std::max(std::min(kThinKernel * (fine * fine), thick), least), std::max(thick, least)};
}

std::size_t most_bricks(const Octree& octree) {
  std::size_t most = 0;
  for (const OctreeLevel& level : octree.levels) most = std::max(most, level.bricks.count);
  return most;
}

/// The bricks 2 B - 1 .. 2 B + 2 of a finer level round each brick B of a coarse one.
Buffer<std::int32_t> children_of(Backend& backend, const OctreeLevel& coarse,
                                 const OctreeLevel& fine) {
  std::vector<BrickCoord> corners = coarse.coords;
  for (BrickCoord& c : corners) c = {2 * c.x - 1, 2 * c.y - 1, 2 * c.z - 1};
  return brick_windows(backend, corners, 4, fine.coords);
}

double relative_norm(float square, float reference) {
  return reference > 0 ? std::sqrt(static_cast<double>(square) / reference) : 0.0;
}

/// Smooths by the variance that is wanted (in cells^2) along one axis, in two passes.
void smooth_axis(Backend& backend, const LevelView& level, int axis, float variance,
                 Buffer<float>& values, Buffer<float>& scratch) {
  // Two passes of variance 2 tap each; above a third the taps would no longer fall off.
  const float tap = std::min(0.25f * variance, 1.0f / 3.0f);
  if (tap <= 0) return;
  backend.isovalue_smooth(level, axis, tap, values.view(), scratch.view());
  backend.isovalue_smooth(level, axis, tap, scratch.view(), values.view());
}

/// Sums over the samples round each place, as splines of a level: of values, each times its
/// sample's weight, and of the weights.
struct LocalSums {
  Buffer<float> values, weights;
};

LocalSums sum_locally(Backend& backend, const OctreeLevel& level, const PointCloud& points,
                      std::span<const float> weights, View<const float> values) {
  Buffer<float> of_points(backend, points.count);
  backend.upload<float>(of_points.view(), weights);
  LocalSums sums = {Buffer<float>(backend, cells(level)), Buffer<float>(backend, cells(level))};
  backend.isovalue_splat(level.view(), index_points(backend, level, points).view(), points.view(),
                         std::as_const(of_points).view(), values, sums.values.view(),
                         sums.weights.view());
  return sums;
}

/// Widens the kernel of the sums to a Gaussian of `sigma` voxel lengths.
void widen(Backend& backend, const OctreeLevel& level, const Scale& scale, float sigma,
           LocalSums& sums) {
  Buffer<float> scratch(backend, cells(level));
  for (int axis = 0; axis < 3; ++axis) {
    const float side = std::ldexp(scale[static_cast<std::size_t>(axis)], level.exponent);
    const float variance = (sigma / side) * (sigma / side) - 0.5f;  // splat, spline: a quarter each
    smooth_axis(backend, level.view(), axis, variance, sums.values, scratch);
    smooth_axis(backend, level.view(), axis, variance, sums.weights, scratch);
  }
}

/// What the local isovalue weighs the samples by: their areas, shared out to the narrow kernel of
/// thin vessels and to the wide one.
struct SampleWeights {
  std::vector<float> narrow, wide;
  float mean = 0.5f;  ///< area-weighted, of the values
};

SampleWeights weigh(Backend& backend, const PointView& points, View<const float> values) {
  for (const View<const float>& axis : points.area) backend.on_host(axis);
  backend.on_host(points.thickness);
  constexpr float kCellsOfWide = 8;  // of the narrow kernel's level: sums count by cells of theirs
  constexpr Kernel kShare = {kLeastWideShare, 1};
  SampleWeights weights{std::vector<float>(points.count), std::vector<float>(points.count)};
  double sum = 0, all = 0;
  in_steps(backend, points.count, [&](std::size_t i) {
    const float ax = points.area[0][i], ay = points.area[1][i], az = points.area[2][i];
    const float area = std::sqrt((ax * ax + ay * ay) + az * az);
    const float share = kShare.at(points.thickness[i]);
    weights.wide[i] = area * share;
    weights.narrow[i] = kCellsOfWide * (area * (1 - share));
    sum += double{area} * values[i];
    all += area;
  });
  if (all > 0) weights.mean = static_cast<float>(sum / all);
  return weights;
}

/// The values' local mean on the regular level.
Buffer<float> local_mean(Backend& backend, const PointCloud& points, const Scale& scale,
                         const Octree& octree, View<const float> values) {
  const SampleWeights weights = weigh(backend, points.view(), values);
  const OctreeLevel &regular = octree.at_exponent(0), &coarse = octree.at_exponent(1);
  LocalSums sums = sum_locally(backend, regular, points, weights.narrow, values);
  widen(backend, regular, scale, kNarrowSigma, sums);
  LocalSums wide = sum_locally(backend, coarse, points, weights.wide, values);
  widen(backend, coarse, scale, kWideSigma, wide);
  Buffer<float> finer(backend, cells(regular));
  const auto add = [&](const Buffer<float>& from, Buffer<float>& to) {
    backend.poisson_prolong(regular.view(), regular.parents.view(), from.view(), finer.view());
    backend.field_add(1, std::as_const(finer).view(), to.view());
  };
  add(wide.values, sums.values);
  add(wide.weights, sums.weights);
  backend.isovalue_divide(weights.mean, std::as_const(sums.weights).view(), sums.values.view());
  return std::move(sums.values);
}

}  // namespace

void SolveWorkspace::resize(Backend& backend, std::size_t bricks) {
  residual.resize(backend, bricks * kBrickCells);
  direction.resize(backend, bricks * kBrickCells);
  partial.resize(backend, bricks);
  partial_b.resize(backend, bricks);
}

SolveOutcome conjugate_gradient(Backend& backend, const LevelView& level,
                                View<const std::uint8_t> unknown, View<const float> b,
                                View<float> x, int iterations, SolveWorkspace& w) {
  w.resize(backend, level.bricks.count);
  const View<float> r = w.residual.view(), p = w.direction.view(), partial = w.partial.view();

  // r = b - A x, p = r
  backend.poisson_residual(level, unknown, b, x, r, p, w.partial_b.view(), partial);
  const float b_square = backend.reduce_sum(w.partial_b.view());
  float r_square = backend.reduce_sum(partial);

  SolveOutcome outcome;
  outcome.initial_residual = relative_norm(r_square, b_square);
  while (outcome.iterations < iterations && r_square > 1e-12f * b_square) {
    // alpha = r.r / p.A p
    backend.poisson_energy(level, unknown, p, partial);
    const float energy = backend.reduce_sum(partial);
    if (!(energy > 0)) break;
    // x += alpha p, r -= alpha A p
    backend.poisson_update_solution(level, unknown, r_square / energy, p, x, r, partial);
    const float next_square = backend.reduce_sum(partial);
    // p = r + beta p
    backend.poisson_update_direction(level, next_square / r_square, r, p);
    r_square = next_square;
    ++outcome.iterations;
  }
  outcome.residual = relative_norm(r_square, b_square);
  return outcome;
}

void assemble_poisson(Backend& backend, const PointCloud& points, const Scale& scale,
                      const Parameters& parameters, Octree& octree) {
  const Kernel kernel = kernel_of(scale, parameters, finest_solved(octree, parameters));
  for (OctreeLevel& level : octree.levels) {
    if (level.exponent > 0) continue;
    const LevelPoints index = index_points(backend, level, points);
    backend.poisson_splat(level.view(), index.view(), points.view(), scale, kernel,
                          level.right_hand_side.view());
  }
  for (int exponent = 1; exponent <= octree.root_exponent(); ++exponent) {
    OctreeLevel& coarse = octree.at_exponent(exponent);
    const OctreeLevel& fine = octree.at_exponent(exponent - 1);
    const auto children = children_of(backend, coarse, fine);
    backend.poisson_restrict(coarse.view(), children.view(), fine.right_hand_side.view(),
                             coarse.right_hand_side.view());
  }
}

void solve_poisson(Scheduler& scheduler, const Parameters& parameters, Octree& octree,
                   std::vector<LevelReport>& reports) {
  Backend& backend = scheduler.backend_for(Stage::poisson);
  const int finest = finest_solved(octree, parameters);
  SolveWorkspace workspace;
  workspace.resize(backend, most_bricks(octree));
  for (std::size_t i = 0; i < octree.levels.size(); ++i) {
    OctreeLevel& level = octree.levels[i];
    if (i == 0)
      backend.fill(level.solution.view(), 0.0f);
    else
      backend.poisson_prolong(level.view(), level.parents.view(),
                              octree.levels[i - 1].solution.view(), level.solution.view());
    SolveOutcome outcome;
    if (level.exponent >= finest) {
      const int iterations = i == 0 ? kRootIterations : kLevelIterations;
      outcome = conjugate_gradient(backend, level.view(), level.unknown.view(),
                                   level.right_hand_side.view(), level.solution.view(), iterations,
                                   workspace);
    }
    level.right_hand_side = {};
    level.unknown = {};
    LevelReport report;
    report.depth = octree.depth(level);
    const std::int64_t side = std::int64_t{3 * kBrickSide} << i;
    report.cells = {side, side, side};
    report.nodes = static_cast<std::int64_t>(cells(level));
    const std::size_t children =
        i + 1 < octree.levels.size() ? octree.levels[i + 1].bricks.count : 0;
    report.leaves = report.nodes - static_cast<std::int64_t>(64 * children);
    report.iterations = outcome.iterations;
    report.initial_residual = outcome.initial_residual;
    report.residual = outcome.residual;
    reports.push_back(report);
    scheduler.progress("poisson", static_cast<double>(i + 1) / octree.levels.size());
  }
}

void subtract_isovalue(Backend& backend, const PointCloud& points, const Scale& scale,
                       Octree& octree) {
  // The field at the samples, from the finest level that holds each.
  Buffer<float> at_points(backend, points.count);
  for (const OctreeLevel& level : octree.levels) {
    if (level.exponent > 0) continue;
    backend.poisson_sample_points(level.view(), index_points(backend, level, points).view(),
                                  points.view(), level.solution.view(), at_points.view());
  }
  for (float& value : backend.on_host(at_points.view())) value += kOutwardBias;
  const Buffer<float> isovalue =
      local_mean(backend, points, scale, octree, std::as_const(at_points).view());
  OctreeLevel& regular = octree.at_exponent(0);
  backend.field_add(-1, isovalue.view(), regular.solution.view());
  if (!octree.has_refined()) return;
  OctreeLevel& refined = octree.at_exponent(-1);
  Buffer<float> finer(backend, cells(refined));
  backend.poisson_prolong(refined.view(), refined.parents.view(), isovalue.view(), finer.view());
  backend.field_add(-1, std::as_const(finer).view(), refined.solution.view());
}

}  // namespace vasamesh

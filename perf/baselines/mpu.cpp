#include "mpu.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mpu_fit.h"

namespace vasamesh::baselines {

namespace {

constexpr double kRadius = 0.75;  // of a ball, over its cell's diagonal
constexpr std::size_t kLeastSamples = 15;
constexpr int kNoChildren = -1;

using Eigen::Vector3d;

struct Cell {
  Vector3d centre;
  double half_edge;
  Quadric quadric;
  double radius = 0;           ///< of the ball whose samples were fitted
  double reach = 0;            ///< from the centre, of the balls below it
  int children = kNoChildren;  ///< the first of eight
};

/// Farther than the tolerance (Taubin's distance), or turned the other way.
bool misfits(const Quadric& quadric, const Sample& sample, double tolerance) {
  const Vector3d gradient = quadric.gradient(sample.position);
  return std::fabs(quadric.value(sample.position)) > tolerance * gradient.norm() ||
         gradient.dot(sample.normal) <= 0;
}

}  // namespace

struct Mpu::Tree {
  SampleIndex index;
  MpuOptions options;
  std::vector<Cell> cells;

  Tree(std::vector<Sample> samples, const MpuOptions& wanted)
      : index(std::move(samples)), options(wanted) {}

  void build();
  /// Fits the cell. \returns whether its samples are farther from the quadric than the tolerance.
  bool fit(Cell& cell) const;
  void split(std::size_t cell);
  void find_reach(Cell& cell) const;
  void add(std::size_t cell, const Vector3d& point, double& values, double& weights) const;
};

void Mpu::Tree::build() {
  Vector3d low = index.samples()[0].position, high = low;
  for (const Sample& sample : index.samples()) {
    low = low.cwiseMin(sample.position);
    high = high.cwiseMax(sample.position);
  }
  cells.push_back({0.5 * (low + high), 0.5 * (high - low).maxCoeff() + 1, {}});
  for (std::size_t next = 0; next < cells.size(); ++next)
    if (fit(cells[next])) split(next);
  for (std::size_t cell = cells.size(); cell-- > 0;) find_reach(cells[cell]);
}

void Mpu::Tree::find_reach(Cell& cell) const {
  cell.reach = cell.radius;
  if (cell.children == kNoChildren) return;
  cell.reach = 0;
  for (int child = 0; child < 8; ++child) {
    const Cell& below = cells[static_cast<std::size_t>(cell.children + child)];
    cell.reach = std::max(cell.reach, below.reach + (below.centre - cell.centre).norm());
  }
}

bool Mpu::Tree::fit(Cell& cell) const {
  const bool may_split = cell.half_edge >= options.least_cell;
  Ball ball{cell.centre, kRadius * 2 * std::sqrt(3.0) * cell.half_edge, cell.half_edge, {}};
  ball.samples = index.within(ball.centre, ball.radius);
  const std::size_t inside = ball.samples.size();
  if (inside < kLeastSamples) {
    ball.samples = index.nearest(ball.centre, kLeastSamples);
    const Vector3d& farthest = index.samples()[ball.samples.back()].position;
    ball.radius = std::max(ball.radius, 1.1 * (farthest - ball.centre).norm());
  }
  cell.radius = ball.radius;
  const auto quadric = fit_ball(index, ball);
  if (quadric) cell.quadric = *quadric;
  if (!quadric && !may_split) {
    ball.samples = index.nearest(ball.centre, 1);  // one side of two sheets
    cell.quadric = *fit_ball(index, ball);
  }
  if (inside == 0 || !may_split) return false;
  return !quadric || std::any_of(ball.samples.begin(), ball.samples.end(), [&](std::uint32_t i) {
    return misfits(*quadric, index.samples()[i], options.tolerance);
  });
}

void Mpu::Tree::split(std::size_t cell) {
  const Vector3d centre = cells[cell].centre;
  const double half = 0.5 * cells[cell].half_edge;
  cells[cell].children = static_cast<int>(cells.size());
  for (int child = 0; child < 8; ++child)
    cells.push_back(
        {centre + half * Vector3d(child & 1 ? 1 : -1, child & 2 ? 1 : -1, child & 4 ? 1 : -1),
         half,
         {}});
}

void Mpu::Tree::add(std::size_t at, const Vector3d& point, double& values, double& weights) const {
  const Cell& cell = cells[at];
  const double distance = (point - cell.centre).norm();
  if (distance >= cell.reach) return;
  if (cell.children != kNoChildren) {
    for (int child = 0; child < 8; ++child)
      add(static_cast<std::size_t>(cell.children + child), point, values, weights);
    return;
  }
  const double weight = blend_weight(distance / cell.radius);
  values += weight * cell.quadric.value(point);
  weights += weight;
}

Mpu::Mpu(std::vector<Sample> samples, const MpuOptions& options)
    : tree_(new Tree(std::move(samples), options)) {
  tree_->build();
}
Mpu::~Mpu() = default;

double Mpu::value(const Vector3d& point) const {
  double values = 0, weights = 0;
  tree_->add(0, point, values, weights);
  return weights > 0 ? values / weights : 1;
}

const std::vector<Sample>& Mpu::samples() const { return tree_->index.samples(); }

}  // namespace vasamesh::baselines

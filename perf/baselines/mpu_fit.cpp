#include "mpu_fit.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <utility>

namespace vasamesh::baselines {

namespace {

constexpr std::size_t kNeighbours = 6;  // that tell the side of a corner
constexpr double kLeastWeight = 1e-6;

using Eigen::Vector3d;
using Coefficients = Quadric::Coefficients;
using Normal = Eigen::Matrix<double, 10, 10>;

/// What nanoflann wants to know of a point set.
struct SampleSet {
  const std::vector<Sample>& samples;

  std::size_t kdtree_get_point_count() const { return samples.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return samples[i].position[static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

double weight_of(const Ball& ball, const Vector3d& p) {
  return blend_weight((p - ball.centre).norm() / ball.radius) + kLeastWeight;
}

/// The mean normal, and whether any sample's is 90 degrees or more from it.
std::pair<Vector3d, bool> mean_normal(const std::vector<Sample>& samples, const Ball& ball) {
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t i : ball.samples)
    sum += weight_of(ball, samples[i].position) * samples[i].normal;
  const Vector3d mean = sum.normalized();
  for (const std::uint32_t i : ball.samples)
    if (samples[i].normal.dot(mean) <= 0) return {mean, true};
  return {mean, false};
}

/// w = A u^2 + 2 B u v + C v^2 + D u + E v + F over the plane across the mean normal.
Quadric fit_height(const std::vector<Sample>& samples, const Ball& ball, const Vector3d& normal) {
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  using Row = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> left = Eigen::Matrix<double, 6, 6>::Zero();
  Row right = Row::Zero();
  for (const std::uint32_t i : ball.samples) {
    const Vector3d x = (samples[i].position - ball.centre) / ball.radius;
    const double a = x.dot(u), b = x.dot(v), weight = weight_of(ball, samples[i].position);
    Row row;
    row << a * a, a * b, b * b, a, b, 1;
    left += weight * row * row.transpose();
    right += weight * x.dot(normal) * row;
  }
  const Row fit = left.completeOrthogonalDecomposition().solve(right);
  const Eigen::Matrix3d square =
      -(fit[0] * u * u.transpose() + 0.5 * fit[1] * (u * v.transpose() + v * u.transpose()) +
        fit[2] * v * v.transpose());
  const Vector3d slope = normal - fit[3] * u - fit[4] * v;
  Quadric quadric{ball.centre, ball.radius, {}};
  quadric.coefficients << -fit[5], slope, square(0, 0), square(1, 1), square(2, 2),
      2 * square(0, 1), 2 * square(1, 2), 2 * square(2, 0);
  return quadric;
}

/// The signed distance of a point by its nearest samples, where they agree on the side.
std::optional<double> side_of(const SampleIndex& index, const Vector3d& point) {
  double sum = 0;
  int outside = 0;
  for (const std::uint32_t i : index.nearest(point, kNeighbours)) {
    const Sample& sample = index.samples()[i];
    const double height = sample.normal.dot(point - sample.position);
    sum += height;
    outside += height > 0;
  }
  if (outside != 0 && outside != static_cast<int>(kNeighbours)) return std::nullopt;
  return sum / kNeighbours;
}

/// The cell's corners and centre, and the samples' middle, which lies inside a thin vessel.
std::array<Vector3d, 10> probes_of(const std::vector<Sample>& samples, const Ball& ball) {
  std::array<Vector3d, 10> probes;
  for (int i = 0; i < 8; ++i)
    probes[i] =
        ball.centre + ball.half_edge * Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  probes[8] = ball.centre;
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t i : ball.samples) sum += samples[i].position;
  probes[9] = sum / static_cast<double>(ball.samples.size());
  return probes;
}

/// Least squares over the samples (value 0) and the cell's corners and centre (their distance).
std::optional<Quadric> fit_general(const SampleIndex& index, const Ball& ball) {
  Normal left = Normal::Zero();
  double weights = 0;
  for (const std::uint32_t i : ball.samples) {
    const Vector3d& p = index.samples()[i].position;
    const Coefficients row = Quadric::monomials((p - ball.centre) / ball.radius);
    const double weight = weight_of(ball, p);
    left += weight * row * row.transpose();
    weights += weight;
  }
  left /= weights;
  std::vector<std::pair<Coefficients, double>> sides;
  for (const Vector3d& point : probes_of(index.samples(), ball))
    if (const auto side = side_of(index, point))
      sides.emplace_back(Quadric::monomials((point - ball.centre) / ball.radius),
                         *side / ball.radius);
  if (sides.empty()) return std::nullopt;
  Coefficients right = Coefficients::Zero();
  const double share = 1 / static_cast<double>(sides.size());
  for (const auto& [row, side] : sides) {
    left += share * row * row.transpose();
    right += share * side * row;
  }
  return Quadric{ball.centre, ball.radius, left.completeOrthogonalDecomposition().solve(right)};
}

}  // namespace

struct SampleIndex::Search {
  using Metric = nanoflann::L2_Simple_Adaptor<double, SampleSet>;
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<Metric, SampleSet, 3, std::uint32_t>;
  SampleSet set;
  Tree tree{3, set};
};

SampleIndex::SampleIndex(std::vector<Sample> samples)
    : samples_(std::move(samples)), search_(new Search{SampleSet{samples_}}) {
  search_->tree.buildIndex();
}
SampleIndex::~SampleIndex() = default;

std::vector<std::uint32_t> SampleIndex::within(const Vector3d& centre, double radius) const {
  std::vector<std::pair<std::uint32_t, double>> found;
  search_->tree.radiusSearch(centre.data(), radius * radius, found,
                             nanoflann::SearchParams(32, 0, false));
  std::vector<std::uint32_t> indices;
  indices.reserve(found.size());
  for (const auto& entry : found) indices.push_back(entry.first);
  return indices;
}

std::vector<std::uint32_t> SampleIndex::nearest(const Vector3d& centre, std::size_t k) const {
  std::vector<std::uint32_t> indices(k);
  std::vector<double> squares(k);
  search_->tree.knnSearch(centre.data(), k, indices.data(), squares.data());
  return indices;
}

Coefficients Quadric::monomials(const Vector3d& x) {
  Coefficients row;
  row << 1, x[0], x[1], x[2], x[0] * x[0], x[1] * x[1], x[2] * x[2], x[0] * x[1], x[1] * x[2],
      x[2] * x[0];
  return row;
}

double Quadric::value(const Vector3d& point) const {
  return radius * coefficients.dot(monomials((point - centre) / radius));
}

Vector3d Quadric::gradient(const Vector3d& point) const {
  const Vector3d x = (point - centre) / radius;
  const Coefficients& c = coefficients;
  return Vector3d(c[1] + 2 * c[4] * x[0] + c[7] * x[1] + c[9] * x[2],
                  c[2] + 2 * c[5] * x[1] + c[7] * x[0] + c[8] * x[2],
                  c[3] + 2 * c[6] * x[2] + c[8] * x[1] + c[9] * x[0]);
}

double blend_weight(double ratio) {
  const double t = 1.5 * ratio;
  if (t < 0.5) return 0.75 - t * t;
  return t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0;
}

std::optional<Quadric> fit_ball(const SampleIndex& index, const Ball& ball) {
  const auto [normal, turns] = mean_normal(index.samples(), ball);
  if (turns) return fit_general(index, ball);
  return fit_height(index.samples(), ball, normal);
}

}  // namespace vasamesh::baselines

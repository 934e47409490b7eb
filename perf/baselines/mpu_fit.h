#pragma once

/// \file
/// The local fits of mpu.h.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "samples.h"

namespace vasamesh::baselines {

/// Samples for searches.
class SampleIndex {
 public:
  explicit SampleIndex(std::vector<Sample> samples);
  ~SampleIndex();

  const std::vector<Sample>& samples() const { return samples_; }
  std::vector<std::uint32_t> within(const Eigen::Vector3d& centre, double radius) const;
  /// The k nearest, nearest first. \pre there are as many.
  std::vector<std::uint32_t> nearest(const Eigen::Vector3d& centre, std::size_t k) const;

 private:
  struct Search;
  std::vector<Sample> samples_;
  std::unique_ptr<Search> search_;
};

/// c + b.x + x.A x about a centre; ten numbers in the order of `monomials`.
struct Quadric {
  using Coefficients = Eigen::Matrix<double, 10, 1>;

  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 1;  ///< coordinates are (point - centre) / radius
  Coefficients coefficients = Coefficients::Zero();

  static Coefficients monomials(const Eigen::Vector3d& x);
  double value(const Eigen::Vector3d& point) const;
  Eigen::Vector3d gradient(const Eigen::Vector3d& point) const;
};

/// The quadratic B-spline of |x| / radius, 0 from 1 on.
double blend_weight(double ratio);

/// A ball round a cell and the samples in it.
struct Ball {
  Eigen::Vector3d centre;
  double radius;
  double half_edge;  ///< of the cell
  std::vector<std::uint32_t> samples;
};

/// The height field or general quadric of a ball; none where its corners tell no inside and
/// outside.
std::optional<Quadric> fit_ball(const SampleIndex& index, const Ball& ball);

}  // namespace vasamesh::baselines

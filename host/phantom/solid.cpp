#include "phantom/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vasamesh::phantom {
namespace {

double part_distance(const Part& part, const Vec3& p) {
  return std::visit([&](const auto& shape) { return shape.distance(p); }, part);
}

double least_distance(const std::vector<Part>& parts, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Part& part : parts) least = std::min(least, part_distance(part, p));
  return least;
}

std::vector<Part> parts_near(const std::vector<Part>& parts, const Vec3& centre, double reach) {
  std::vector<Part> found;
  for (const Part& part : parts)
    if (part_distance(part, centre) <= reach) found.push_back(part);
  return found;
}

}  // namespace

RoundCone::RoundCone(const Vec3& a, const Vec3& b, double radius_a, double radius_b)
    : a_(a),
      axis_(Vec3::Zero()),
      length_((b - a).norm()),
      radius_a_(radius_a),
      radius_b_(radius_b),
      slope_(0),
      lean_(0) {
  if (length_ <= std::abs(radius_a - radius_b)) {  // one ball holds the other
    if (radius_b > radius_a) a_ = b, radius_a_ = radius_b;
    length_ = 0;
    return;
  }
  axis_ = (b - a) / length_;
  slope_ = (radius_a - radius_b) / length_;
  lean_ = slope_ / std::sqrt(1 - slope_ * slope_);
}

// The least over t in [0, length] of |p - (a + t axis)| - (radius_a - slope t), convex in t.
double RoundCone::distance(const Vec3& p) const {
  const Vec3 from_a = p - a_;
  const double along = from_a.dot(axis_);
  const double away = std::sqrt(std::max(0.0, from_a.squaredNorm() - along * along));
  const double t = std::clamp(along - away * lean_, 0.0, length_);
  return std::sqrt((along - t) * (along - t) + away * away) - (radius_a_ - slope_ * t);
}

Eigen::AlignedBox3d RoundCone::bounds() const {
  const Vec3 b = a_ + length_ * axis_;
  const double radius_b = length_ > 0 ? radius_b_ : radius_a_;
  Eigen::AlignedBox3d box;
  box.extend(a_ - Vec3::Constant(radius_a_)).extend(a_ + Vec3::Constant(radius_a_));
  box.extend(b - Vec3::Constant(radius_b)).extend(b + Vec3::Constant(radius_b));
  return box;
}

double Torus::distance(const Vec3& p) const {
  const Vec3 from_centre = p - centre;
  const double height = from_centre.dot(axis);
  const double away = std::sqrt(std::max(0.0, from_centre.squaredNorm() - height * height));
  return std::hypot(away - ring, height) - tube;
}

Eigen::AlignedBox3d Torus::bounds() const {
  const Vec3 reach = Vec3::Constant(ring + tube);
  return {centre - reach, centre + reach};
}

double Shape::distance(const Vec3& p) const {
  const double outside = least_distance(parts, p);
  return holes.empty() ? outside : std::max(outside, -least_distance(holes, p));
}

Shape Shape::near(const Vec3& centre, double reach) const {
  return {parts_near(parts, centre, reach), parts_near(holes, centre, reach)};
}

Eigen::AlignedBox3d Shape::bounds() const {
  Eigen::AlignedBox3d box;
  for (const Part& part : parts)
    box.extend(std::visit([](const auto& shape) { return shape.bounds(); }, part));
  return box;
}

void append_tube(std::vector<Part>& parts, const std::vector<Vec3>& points,
                 const std::vector<double>& radius) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    parts.emplace_back(RoundCone(points[i], points[i + 1], radius[i], radius[i + 1]));
}

}  // namespace vasamesh::phantom

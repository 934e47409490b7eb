#include "support/analytic_field.h"

#include <cmath>

namespace vasamesh::test {

AnalyticField::AnalyticField(int side, const std::function<float(const Vec3&)>& value)
    : bricks_(side / 4) {
  const int nodes = 8 * bricks_;
  const auto at = [&](int x, int y, int z) {
    return value(
        {0.5f * static_cast<float>(x), 0.5f * static_cast<float>(y), 0.5f * static_cast<float>(z)});
  };
  brick_at_.resize(static_cast<std::size_t>(bricks_) * bricks_ * bricks_);
  for (std::size_t b = 0; b < brick_at_.size(); ++b) brick_at_[b] = static_cast<std::int32_t>(b);
  coefficients_.resize(kBrickCells * brick_at_.size());
  for (int z = 0; z < nodes; ++z)
    for (int y = 0; y < nodes; ++y)
      for (int x = 0; x < nodes; ++x) {
        const float middle = at(x, y, z);
        const float differences = at(x - 1, y, z) + at(x + 1, y, z) + at(x, y - 1, z) +
                                  at(x, y + 1, z) + at(x, y, z - 1) + at(x, y, z + 1) - 6 * middle;
        const std::size_t brick =
            x / 8 + static_cast<std::size_t>(bricks_) * (y / 8 + bricks_ * (z / 8));
        coefficients_[kBrickCells * brick + brick_cell(x & 7, y & 7, z & 7)] =
            middle - 0.125f * differences;
      }
}

FieldView AnalyticField::view() {
  FieldView view;
  view.grid = {bricks_, bricks_, bricks_};
  view.brick_at = {brick_at_.data(), 0, brick_at_.size()};
  view.coefficients = {coefficients_.data(), 0, coefficients_.size()};
  return view;
}

SizeView AnalyticField::sizes(float size) {
  SizeView sizes;  // no bricks: the same size everywhere
  sizes.elsewhere = size;
  return sizes;
}

AnalyticField sphere_field(int side, const Vec3& centre, float radius) {
  return {side, [=](const Vec3& p) { return radius - norm(p - centre); }};
}

AnalyticField torus_field(int side, const Vec3& centre, float large, float small) {
  return {side, [=](const Vec3& p) {
            const Vec3 q = p - centre;
            const float ring = std::sqrt(q.x * q.x + q.y * q.y) - large;
            return small - std::sqrt(ring * ring + q.z * q.z);
          }};
}

AnalyticField plane_field(int side, float height) {
  return {side, [=](const Vec3& p) { return height - p.z; }};
}

}  // namespace vasamesh::test

#include "stages/near_triangles.h"

#include <algorithm>
#include <bit>

#include "types/least_most.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kSure = 0.9999f;      // of a squared limit: against rounding
constexpr float kLeastReach = 0.05f;  // of what rounding leaves certain, voxel lengths
/// Of the squared sum of the squared sides: with a lesser squared area a plane is not to be
/// trusted.
constexpr float kNeedle = 1e-5f;

/// As squared_to_segment() of types/segment.h, without a branch; `ap` leads from a to p.
float squared_to_side(const Vec3& ap, const Vec3& ab) {
  const float length = squared_norm(ab);
  const float s = least(most(dot(ap, ab), 0.0f), length) / most(length, 1e-30f);
  return squared_norm(ap - s * ab);
}

/// A bound from above of the squared distance from p: to the plane over a triangle that is not a
/// needle, else to its sides.
float squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, bc = c - b, ca = a - c, ap = p - a, bp = p - b, cp = p - c;
  const float to_sides =
      least(least(squared_to_side(ap, ab), squared_to_side(bp, bc)), squared_to_side(cp, ca));
  const Vec3 n = cross(ab, bc);
  const float area = squared_norm(n), height = dot(n, ap);
  const float inside =
      least(least(dot(cross(n, ab), ap), dot(cross(n, bc), bp)), dot(cross(n, ca), cp));
  const float sides = (squared_norm(ab) + squared_norm(bc)) + squared_norm(ca);
  const float to_plane = area > kNeedle * (sides * sides) ? height * height / area : to_sides;
  return inside >= 0 ? least(to_plane, to_sides) : to_sides;
}

}  // namespace

void NearTriangles::take_up(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) box.take_in(p);
  take_up(box.widened(limit_), points[0]);
}

bool NearTriangles::hold_ball(const Vec3& middle, float radius) {
  const float reach = limit_ - radius;
  if (reach < kLeastReach) return false;
  if (within(middle, reach)) return true;
  take_up(Box{middle, middle}.widened(reach), middle);
  return within(middle, reach) != 0;
}

void NearTriangles::take_up(const Box& box, const Vec3& origin) {
  found_.clear();
  for_each_leaf(tree_, box, 0, [&](std::size_t leaf) {
    for (unsigned hits = meeting(tree_.levels[0][leaf], box); hits; hits &= hits - 1)
      found_.push_back(tree_.order[8 * leaf + static_cast<std::size_t>(std::countr_zero(hits))]);
  });
  origin_ = origin;
  size_ = 0;
  const std::size_t step = std::max<std::size_t>(1, (found_.size() + kMost - 1) / kMost);
  for (std::size_t i = 0; i < found_.size(); i += step) add(found_[i]);
}

void NearTriangles::add(std::uint32_t triangle) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 p = vertex_at(mesh_, mesh_.triangles[3 * std::size_t{triangle} + k]) - origin_;
    corner_[3 * k][size_] = p.x;
    corner_[3 * k + 1][size_] = p.y;
    corner_[3 * k + 2][size_] = p.z;
  }
  ++size_;
}

NearTriangles::Set NearTriangles::within(const Vec3& point, float reach) const {
  const float most = kSure * (reach * reach);
  const Vec3 p = point - origin_;
  const auto& x = corner_;
  Set found = 0;
  for (std::size_t eight = 0; eight < size_; eight += 8) {
    float squared[8];
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t at = eight + i;
      squared[i] = squared_distance(p, {x[0][at], x[1][at], x[2][at]},
                                    {x[3][at], x[4][at], x[5][at]}, {x[6][at], x[7][at], x[8][at]});
    }
    for (std::size_t i = 0; i < 8; ++i) found |= Set{squared[i] <= most} << (eight + i);
  }
  return size_ < kMost ? found & ((Set{1} << size_) - 1) : found;
}

}  // namespace vasamesh

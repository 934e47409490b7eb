#pragma once

/// \file
/// When a triangle or a chord over a gap counts as lying on the surface.

#include <algorithm>
#include <cstdint>

#include "types/gaps.h"
#include "types/indicator_field.h"
#include "types/mesh_vertex.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The square of the cosine of a triangle's least angle, from the squares of its edges: 1/4 for an
/// equilateral triangle, growing to 1 as the least angle goes to 0. The least angle lies across
/// from the shortest edge and is at most 60 degrees, so that the square orders as the angle does.
inline float least_angle_measure(float a, float b, float c) {
  const float low = std::min(a, b), high = std::max(a, b);
  const float least = std::min(low, c), longest = std::max(high, c);
  const float middle = std::max(low, std::min(high, c));
  const float cosine = (middle + longest) - least;
  return (cosine * cosine) / (4.0f * (middle * longest));
}

inline float least_angle_measure(const Vec3& a, const Vec3& b, const Vec3& c) {
  return least_angle_measure(squared_norm(b - a), squared_norm(c - b), squared_norm(a - c));
}

/// Whether the sample lies within sqrt(squared_reach) of the surface, to first order.
inline bool is_near_surface(const FieldSample& sample, float squared_reach) {
  return sample.known &&
         sample.value * sample.value <= squared_reach * squared_norm(sample.gradient);
}

/// Whether a straight edge follows the surface.
inline bool chord_follows_surface(const GapRules& rules, const Vec3& a, const Vec3& b) {
  const FieldSample middle = sample_field(rules.field, 0.5f * (a + b));
  return is_near_surface(middle, rules.reach * rules.reach * squared_norm(b - a));
}

/// Whether dot >= cosine * length; with a cosine of zero, dot > 0. `squared`: the length's square.
inline bool is_within_angle(float dot, float cosine, float squared) {
  const float bound = (cosine * cosine) * squared;
  return cosine < 0 ? dot > 0 || dot * dot <= bound : dot > 0 && dot * dot >= bound;
}

/// Whether the middle of the triangle (a, b, c) lies near the surface and faces as it does.
/// `cross` is twice the area times the triangle's normal.
inline bool middle_follows_surface(const GapRules& rules, const Vec3& a, const Vec3& b,
                                   const Vec3& c, const Vec3& cross) {
  const FieldSample middle = sample_field(rules.field, (1.0f / 3.0f) * ((a + b) + c));
  const float longest = std::max({squared_norm(b - a), squared_norm(c - b), squared_norm(a - c)});
  return is_near_surface(middle, rules.reach * rules.reach * longest) &&
         is_within_angle(-dot(middle.gradient, cross), rules.middle_cosine,
                         squared_norm(middle.gradient) * squared_norm(cross));
}

/// Whether the triangle (a, b, c) with the outward normals of its corners follows the surface.
inline bool triangle_follows_surface(const GapRules& rules, const Vec3 (&p)[3],
                                     const Vec3 (&normal)[3]) {
  const Vec3 product = cross(p[1] - p[0], p[2] - p[0]);
  const float squared = squared_norm(product);
  if (!(squared > 0)) return false;
  for (const Vec3& n : normal)
    if (!is_within_angle(dot(n, product), rules.least_cosine, squared)) return false;
  return middle_follows_surface(rules, p[0], p[1], p[2], product);
}

}  // namespace vasamesh

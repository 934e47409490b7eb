#pragma once

/// \file
/// Vectors of three float32 in one specified arithmetic: sums are (x + y) + z, nothing is fused.

#include <cmath>

namespace vasamesh {

struct Vec3 {
  float x = 0, y = 0, z = 0;
  bool operator==(const Vec3&) const = default;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(float s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }

inline float dot(const Vec3& a, const Vec3& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float squared_norm(const Vec3& a) { return dot(a, a); }
inline float norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// The zero vector where the norm is zero.
inline Vec3 normalised(const Vec3& a) {
  const float length = norm(a);
  return length > 0 ? (1.0f / length) * a : Vec3{};
}

/// A unit vector at right angles to a unit vector: along the cross product with the axis that it is
/// farthest from.
inline Vec3 any_tangent(const Vec3& n) {
  const float x = n.x * n.x, y = n.y * n.y, z = n.z * n.z;
  if (x <= y && x <= z) return normalised(Vec3{0, n.z, -n.y});
  if (y <= z) return normalised(Vec3{-n.z, 0, n.x});
  return normalised(Vec3{n.y, -n.x, 0});
}

}  // namespace vasamesh

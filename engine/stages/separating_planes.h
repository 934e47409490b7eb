#pragma once

/// \file
/// Pairs of triangles that planes tell apart for certain, in float32 or in double.
///
/// Gottschalk, Lin, Manocha: OBBTree, 1996 (separating axes); Shewchuk: Adaptive precision
/// floating-point arithmetic and fast robust geometric predicates, 1997 (the bounds of errors).

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vasamesh {

// With u the unit roundoff and all components of the vectors at most m in size, where a vector
// carries one rounding of a difference:
//   |error of dot(k, p)| <= 5 u |k|_1 m for any k;
//   |error of dot(cross(a, b), c)| <= 8 u * 6 m^3;
//   |error of dot(cross(a, b), cross(c, d))| <= 12 u * 12 m^4.
template <class Scalar>
inline constexpr Scalar kRoundoff = std::numeric_limits<Scalar>::epsilon() / 2;
template <class Scalar>
inline constexpr Scalar kDotError = 8 * kRoundoff<Scalar>;
template <class Scalar>
inline constexpr Scalar kDeterminantError = 64 * kRoundoff<Scalar>;
template <class Scalar>
inline constexpr Scalar kCrossDotError = 192 * kRoundoff<Scalar>;

/// The corners of two triangles, those that they share first, relative to the first of `a`.
template <class Vector>
struct CornerPair {
  using Scalar = decltype(Vector::x);

  std::array<Vector, 3> a, b;
  int common = 0;     ///< how many they share
  Scalar extent = 0;  ///< the largest component
};

template <class Vector>
auto largest_component(const Vector& a) {
  return std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
}

namespace separating_planes {

template <class Vector>
auto dot_error(const Vector& axis, decltype(Vector::x) extent) {
  return kDotError<decltype(Vector::x)> *
         ((std::fabs(axis.x) + std::fabs(axis.y)) + std::fabs(axis.z)) * extent;
}

/// Whether planes across `axis` lie between two triangles.
template <class Vector>
bool separates(const Vector& axis, const CornerPair<Vector>& pair) {
  const auto a0 = dot(axis, pair.a[0]), a1 = dot(axis, pair.a[1]), a2 = dot(axis, pair.a[2]);
  const auto b0 = dot(axis, pair.b[0]), b1 = dot(axis, pair.b[1]), b2 = dot(axis, pair.b[2]);
  const auto error = 2 * dot_error(axis, pair.extent);
  return std::min({a0, a1, a2}) > std::max({b0, b1, b2}) + error ||
         std::min({b0, b1, b2}) > std::max({a0, a1, a2}) + error;
}

template <class Vector>
std::array<Vector, 3> edges_of(const std::array<Vector, 3>& corner) {
  return {corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
}

/// Two triangles without a common vertex: across the normals, across the edges in their planes,
/// across an edge of each.
template <class Vector>
bool are_disjoint(const CornerPair<Vector>& pair) {
  const std::array<Vector, 3> e = edges_of(pair.a), f = edges_of(pair.b);
  const Vector n = cross(e[0], e[1]), o = cross(f[0], f[1]);
  if (separates(n, pair) || separates(o, pair)) return true;
  for (const Vector& edge : e)
    if (separates(cross(n, edge), pair)) return true;
  for (const Vector& edge : f)
    if (separates(cross(o, edge), pair)) return true;
  for (const Vector& edge : e)
    for (const Vector& other : f)
      if (separates(cross(edge, other), pair)) return true;
  return false;
}

/// Whether x and y are of one sign, each beyond `error`.
template <class Scalar>
bool same_side(Scalar x, Scalar y, Scalar error) {
  return (x > error && y > error) || (x < -error && y < -error);
}

/// Whether the plane through the common vertex across `axis` lies between the triangles.
template <class Vector>
bool divides(const Vector& axis, const CornerPair<Vector>& pair) {
  const auto error = dot_error(axis, pair.extent);
  return dot(axis, pair.a[1]) > error && dot(axis, pair.a[2]) > error &&
         dot(axis, pair.b[1]) < -error && dot(axis, pair.b[2]) < -error;
}

template <class Vector>
Vector unit(const Vector& a) {
  return (1 / std::sqrt(dot(a, a))) * a;
}

/// Two triangles with one common vertex.
template <class Vector>
bool meet_in_vertex(const CornerPair<Vector>& pair) {
  const Vector &a = pair.a[1], &b = pair.a[2], &c = pair.b[1], &d = pair.b[2];
  if (divides((a + b) - (c + d), pair)) return true;
  const auto m = pair.extent, error = kDeterminantError<decltype(Vector::x)> * ((m * m) * m);
  const Vector n = cross(a, b), o = cross(c, d);
  return same_side(dot(n, c), dot(n, d), error) || same_side(dot(o, a), dot(o, b), error) ||
         divides((unit(a) + unit(b)) - (unit(c) + unit(d)), pair);
}

/// Two triangles with a common edge: not folded onto each other.
template <class Vector>
bool are_unfolded(const CornerPair<Vector>& pair) {
  using Scalar = decltype(Vector::x);
  const Vector &edge = pair.a[1], &a = pair.a[2], &b = pair.b[2];
  const Scalar m = pair.extent;
  const Vector n = cross(edge, a);
  return dot(n, cross(edge, b)) < -kCrossDotError<Scalar> * ((m * m) * (m * m)) ||
         std::fabs(dot(n, b)) > kDeterminantError<Scalar> * ((m * m) * m);
}

}  // namespace separating_planes

/// Whether the triangles, neither degenerate, certainly meet in nothing but what they share. The
/// extent must be such that nothing underflows or overflows.
template <class Vector>
bool are_certainly_apart(const CornerPair<Vector>& pair) {
  switch (pair.common) {
    case 0:
      return separating_planes::are_disjoint(pair);
    case 1:
      return separating_planes::meet_in_vertex(pair);
    case 2:
      return separating_planes::are_unfolded(pair);
    default:
      return false;
  }
}

}  // namespace vasamesh

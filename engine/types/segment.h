#pragma once

/// \file
/// Points and segments, in vectors of float32 or of doubles.

#include <algorithm>

namespace vasamesh {

/// How far along a segment its nearest point to p is: 0 where it begins, 1 where it ends.
/// \param ap  from where it begins to p; `ab`: to where it ends.
template <class Vector>
auto nearest_along(const Vector& ap, const Vector& ab) {
  const auto length = dot(ab, ab);
  using Scalar = decltype(dot(ap, ab));
  return length > 0 ? std::clamp(dot(ap, ab) / length, Scalar{0}, Scalar{1}) : Scalar{0};
}

/// The square of the distance from p to the segment from a to b.
template <class Vector>
auto squared_to_segment(const Vector& p, const Vector& a, const Vector& b) {
  const Vector ab = b - a, ap = p - a;
  const Vector off = ap - nearest_along(ap, ab) * ab;
  return dot(off, off);
}

}  // namespace vasamesh

#pragma once

/// \file
/// Directions to try in a search across a normal.

#include <array>

#include "types/vec3.h"

namespace vasamesh {

/// Directions of a compass, as (cosine, sine).
inline constexpr std::array<std::array<float, 2>, 8> kCompass = {{{1, 0},
                                                                  {0.70710678f, 0.70710678f},
                                                                  {0, 1},
                                                                  {-0.70710678f, 0.70710678f},
                                                                  {-1, 0},
                                                                  {-0.70710678f, -0.70710678f},
                                                                  {0, -1},
                                                                  {0.70710678f, -0.70710678f}}};

/// Two unit vectors across a unit normal.
inline std::array<Vec3, 2> tangents(const Vec3& normal) {
  const Vec3 axis = normal.x * normal.x < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalised(cross(normal, axis));
  return {u, cross(normal, u)};
}

}  // namespace vasamesh

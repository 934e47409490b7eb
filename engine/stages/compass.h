#pragma once

/// \file
/// Directions to try in a search across a normal. What is done to all places of a compass is one
/// loop over local arrays, so that it becomes vectors.

#include <array>
#include <cstddef>

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

/// A value a direction of a compass.
using CompassValues = std::array<float, kCompass.size()>;

/// A place a direction of a compass.
struct CompassPlaces {
  CompassValues x, y, z;

  Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
};

/// Two unit vectors across a unit normal; not any_tangent() and what is across it.
inline std::array<Vec3, 2> tangents(const Vec3& normal) {
  const Vec3 axis = normal.x * normal.x < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalised(cross(normal, axis));
  return {u, cross(normal, u)};
}

/// Six unit vectors across a unit normal, each 60 degrees from the one before.
inline std::array<Vec3, 6> hexagon_across(const Vec3& normal) {
  constexpr float kHalf = 0.5f, kSine = 0.8660254f;
  constexpr float kDirections[6][2] = {{1, 0},  {kHalf, kSine},   {-kHalf, kSine},
                                       {-1, 0}, {-kHalf, -kSine}, {kHalf, -kSine}};
  const Vec3 u = any_tangent(normal), v = cross(normal, u);
  std::array<Vec3, 6> directions;
  for (std::size_t i = 0; i < directions.size(); ++i)
    directions[i] = kDirections[i][0] * u + kDirections[i][1] * v;
  return directions;
}

/// The places in all directions at a distance from a point.
inline CompassPlaces compass_round(const Vec3& from, float distance,
                                   const std::array<Vec3, 2>& axes) {
  CompassPlaces places;
  for (std::size_t k = 0; k < kCompass.size(); ++k) {
    const auto [cosine, sine] = kCompass[k];
    const Vec3 place = from + distance * (cosine * axes[0] + sine * axes[1]);
    places.x[k] = place.x, places.y[k] = place.y, places.z[k] = place.z;
  }
  return places;
}

}  // namespace vasamesh

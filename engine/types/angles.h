#pragma once

/// \file
/// Angles in one specified arithmetic: fixed polynomials in float32, to about 1e-4 radians.

#include <cmath>

namespace vasamesh {

inline constexpr float kPi = 3.14159265f;

/// The angle of the vector (x, y) from the x axis, -pi to pi; 0 of no vector.
inline float angle_of(float x, float y) {
  const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
  const float least = ax < ay ? ax : ay, most = ax < ay ? ay : ax;
  if (!(most > 0)) return 0;
  const float t = least / most, s = t * t;
  float a =
      t * (0.99997726f +
           s * (-0.33262347f +
                s * (0.19354346f + s * (-0.11643287f + s * (0.05265332f + s * -0.01172120f)))));
  if (ay > ax) a = 0.5f * kPi - a;
  if (x < 0) a = kPi - a;
  return y < 0 ? -a : a;
}

/// The same, from 0 to 2 pi.
inline float positive_angle(float x, float y) {
  const float a = angle_of(x, y);
  return y < 0 ? 2 * kPi + a : a;
}

struct Rotation {
  float cosine = 1, sine = 0;

  /// This turn, then another.
  Rotation then(const Rotation& by) const {
    return {cosine * by.cosine - sine * by.sine, sine * by.cosine + cosine * by.sine};
  }
};

/// \pre |angle| is at most 2.
inline Rotation rotation_by(float angle) {
  const float s = angle * angle;
  return {1 - s * (0.5f - s * (1 / 24.0f - s * (1 / 720.0f - s * (1 / 40320.0f)))),
          angle * (1 - s * (1 / 6.0f - s * (1 / 120.0f - s * (1 / 5040.0f - s / 362880.0f))))};
}

}  // namespace vasamesh

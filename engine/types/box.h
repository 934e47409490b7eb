#pragma once

/// \file
/// Boxes along the axes.

#include <algorithm>
#include <limits>

#include "types/vec3.h"

namespace vasamesh {

/// From `low` to `high`, both in it. As made, the empty box, with low above high.
struct Box {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  Vec3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};

  void take_in(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void take_in(const Box& other) {
    low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y),
           std::min(low.z, other.low.z)};
    high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y),
            std::max(high.z, other.high.z)};
  }

  /// This box with a margin on all sides.
  Box widened(float margin) const {
    const Vec3 by = {margin, margin, margin};
    return {low - by, high + by};
  }

  /// Whether a point lies in it, or up to `margin` beyond along each axis.
  bool holds(const Vec3& p, float margin = 0) const {
    return p.x >= low.x - margin && p.x <= high.x + margin && p.y >= low.y - margin &&
           p.y <= high.y + margin && p.z >= low.z - margin && p.z <= high.z + margin;
  }

  /// Whether it and another, neither empty, touch or are at most `reach` apart along each axis.
  bool meets(const Box& other, float reach = 0) const {
    return low.x - reach <= other.high.x && other.low.x - reach <= high.x &&
           low.y - reach <= other.high.y && other.low.y - reach <= high.y &&
           low.z - reach <= other.high.z && other.low.z - reach <= high.z;
  }

  Vec3 middle() const { return 0.5f * (low + high); }

  float longest_side() const {
    const Vec3 side = high - low;
    return std::max({side.x, side.y, side.z});
  }
};

}  // namespace vasamesh

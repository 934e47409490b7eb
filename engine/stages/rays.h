#pragma once

/// \file
/// Rays along +x through a triangle surface. Which triangles a ray crosses is exact; points that
/// lie on the ray are moved away by a symbolic perturbation (Edelsbrunner, Muecke: Simulation of
/// simplicity, 1990).

#include <bit>
#include <cstdint>
#include <limits>

#include "stages/triangle_tree.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// A triangle that a ray crosses.
struct RayCrossing {
  std::uint32_t triangle;
  bool exit;  ///< the ray leaves through the triangle's front
  double x;   ///< rounded
};

class RayCaster {
 public:
  /// Both must outlive the caster.
  RayCaster(const TriangleMesh& mesh, const TriangleTree& tree) : mesh_(mesh), tree_(tree) {}

  /// Calls visit(crossing) for the triangles of the tree that the ray from `p` along +x crosses, in
  /// no particular order.
  template <class Visit>
  void cast(const float* p, const Visit& visit) const {
    if (tree_.empty()) return;
    const Box ray{{p[0], p[1], p[2]}, {std::numeric_limits<float>::max(), p[1], p[2]}};
    for_each_leaf(tree_, ray, 0, [&](std::size_t leaf) {
      for (unsigned hits = meeting(tree_.levels[0][leaf], ray); hits; hits &= hits - 1) {
        const std::uint32_t t = tree_.order[8 * leaf + std::countr_zero(hits)];
        if (const int side = crossing_side(t, p)) visit({t, side > 0, crossing_x(t, p)});
      }
    });
  }

 private:
  /// 1 where the ray leaves through the triangle's front, -1 through its back, 0 where it misses.
  int crossing_side(std::uint32_t triangle, const float* p) const;
  double crossing_x(std::uint32_t triangle, const float* p) const;

  const TriangleMesh& mesh_;
  const TriangleTree& tree_;
};

}  // namespace vasamesh

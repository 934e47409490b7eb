/// Small angles made wider by geometry alone.

#include <algorithm>
#include <cmath>
#include <optional>

#include "stages/patch_mending.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kWanted = 1.05f * kSquaredSine20;  // a little more than is asked for
constexpr float kGain = 1.01f;                     // the least by which a squared sine must grow
constexpr float kLastStep = 0.01f;                 // of the mean edge round a vertex

/// The least squared sine of the triangles round v with `point` in its place; -1 where one of them
/// turns by 90 degrees or more.
float fan_squared_sine(const PatchMesh& mesh, std::uint32_t v, const SurfacePoint& point) {
  float least = 1;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const SurfacePoint &b = mesh.points[mesh.target(h)], &c = mesh.points[mesh.apex(h)];
    const bool turned = turns(area_vector(mesh.points[v], b, c), area_vector(point, b, c), 0);
    least = std::min(least, turned ? -1 : least_squared_sine(point, b, c));
  });
  return least;
}

struct Widening {
  static constexpr float least_turn = 0;

  bool is_poor(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) const {
    return least_squared_sine(a, b, c) < kWanted;
  }

  bool prefers_flip(const SurfacePoint& p, const SurfacePoint& q, const SurfacePoint& c,
                    const SurfacePoint& d) const {
    const float before = std::min(least_squared_sine(p, q, c), least_squared_sine(q, p, d));
    return std::min(least_squared_sine(d, c, p), least_squared_sine(c, d, q)) > kGain * before;
  }

  /// The place of v with the widest least angle round it.
  std::optional<SurfacePoint> better_place(const PatchMesh& mesh, std::uint32_t v) const {
    const float before = fan_squared_sine(mesh, v, mesh.points[v]);
    float widest = before;
    SurfacePoint best = search_around(mesh, v, kLastStep, [&](const SurfacePoint& point) {
      const float squared_sine = fan_squared_sine(mesh, v, point);
      if (!(squared_sine > kGain * widest && squared_sine > widest)) return false;
      widest = squared_sine;
      return true;
    });
    if (!(widest > before)) return std::nullopt;
    best.on_field = false;
    return best;
  }
};

}  // namespace

void widen_angles(PatchMesh& mesh, int passes) { mend_triangles(mesh, Widening{}, passes); }

}  // namespace vasamesh

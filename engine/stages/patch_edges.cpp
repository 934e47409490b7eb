/// Edges of unequal lengths made more equal by geometry alone.

#include <algorithm>
#include <optional>

#include "stages/compass.h"
#include "stages/fan_moves.h"
#include "stages/patch_mending.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

// Of squared edge ratios, shortest over longest.
constexpr float kWanted = 1.03f * kLeastSquaredEdgeRatio;  // a little more than is asked for
constexpr float kPlain = 0.5f;                             // what lies below counts
constexpr float kUnequal = 5;                              // times as much as what lies above
constexpr float kLeastBend = 0.75f;  // cosine between the triangles at an edge that may turn
constexpr float kFlipGain = 0.01f, kMoveGain = 0.002f;

constexpr float kFirstStep = 0.16f, kLastStep = 0.03f, kMostMove = 0.25f;  // of the size

/// Grows with the squared edge ratio, up to where it is good enough, and faster where it is poor.
float worth(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
  const float equality = squared_edge_ratio(a.position, b.position, c.position);
  return std::min(equality, kEnoughEquality) + (kUnequal - 1) * std::min(equality - kPlain, 0.0f);
}

struct Evening {
  static constexpr float least_turn = 0.9f;

  bool is_poor(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) const {
    return squared_edge_ratio(a.position, b.position, c.position) < kWanted;
  }

  /// Edges that the surface is bent along stay.
  bool prefers_flip(const SurfacePoint& p, const SurfacePoint& q, const SurfacePoint& c,
                    const SurfacePoint& d) const {
    return !turns(area_vector(p, q, c), area_vector(q, p, d), kLeastBend) &&
           worth(d, c, p) + worth(c, d, q) > worth(p, q, c) + worth(q, p, d) + kFlipGain &&
           std::min(least_squared_sine(d, c, p), least_squared_sine(c, d, q)) >= kSquaredSine25;
  }

  /// The worth of the triangles round v with `point` in its place; none where one of them turns too
  /// far or gets a small angle.
  std::optional<float> fan_worth(const PatchMesh& mesh, std::uint32_t v,
                                 const SurfacePoint& point) const {
    float sum = 0;
    bool good = true;
    const SurfacePoint& old = mesh.points[v];
    mesh.for_each_out(v, [&](std::uint32_t h) {
      const SurfacePoint &b = mesh.points[mesh.target(h)], &c = mesh.points[mesh.apex(h)];
      good = good && !turns(area_vector(old, b, c), area_vector(point, b, c), least_turn) &&
             least_squared_sine(point, b, c) >=
                 std::min(kSquaredSine25, least_squared_sine(old, b, c));
      sum += worth(point, b, c);
    });
    return good ? std::optional(sum) : std::nullopt;
  }

  /// Compass search in the tangent plane for the place of v of most worth.
  std::optional<SurfacePoint> better_place(const PatchMesh& mesh, std::uint32_t v) const {
    const Vec3 start = mesh.points[v].position;
    const auto [u, w] = tangents(fan_normal(mesh, v));
    SurfacePoint best = mesh.points[v];
    best.on_field = false;
    const float farthest = kMostMove * best.size;
    std::optional<float> most = fan_worth(mesh, v, best);
    if (!most) return std::nullopt;
    for (float step = kFirstStep; step > kLastStep;) {
      const Vec3 from = best.position;
      for (const auto& [cosine, sine] : kCompass) {
        SurfacePoint point = best;
        point.position = from + (step * best.size) * (cosine * u + sine * w);
        if (squared_norm(point.position - start) > farthest * farthest) continue;
        const std::optional<float> found = fan_worth(mesh, v, point);
        if (!found || !(*found > *most + kMoveGain)) continue;
        most = found;
        best = point;
      }
      if (best.position == from) step *= 0.5f;
    }
    if (best.position == start) return std::nullopt;
    return best;
  }
};

}  // namespace

void even_edges(PatchMesh& mesh, int passes) { mend_triangles(mesh, Evening{}, passes); }

}  // namespace vasamesh

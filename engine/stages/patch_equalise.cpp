/// Moves towards equal edges.

#include "stages/compass.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.1f;    // voxel lengths that the projection may move a vertex
constexpr float kEnough = 0.72f;  // squared edge ratio above which a triangle needs no more

/// Sum over the fan of the squared edge ratios, each at most kEnough.
float fan_equality(const PatchMesh& mesh, std::uint32_t v, const Vec3& p) {
  float sum = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const Vec3& q = mesh.points[mesh.target(h)].position;
    const Vec3& r = mesh.points[mesh.apex(h)].position;
    const float a = squared_norm(q - p), b = squared_norm(r - q), c = squared_norm(p - r);
    const float longest = std::max({a, b, c});
    if (longest > 0) sum += std::min(std::min({a, b, c}) / longest, kEnough);
  });
  return sum;
}

void equalise_vertex(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v) {
  const SurfacePoint old = mesh.points[v];
  const float before = fan_equality(mesh, v, old.position);
  if (before >= kEnough * static_cast<float>(mesh.fan_size(v)) - 1e-3f) return;
  const auto [u, w] = tangents(old.normal);
  Vec3 place = old.position;
  float best = before;
  for (float step : {0.08f, 0.04f}) {
    const Vec3 from = place;
    for (const auto& [cosine, sine] : kCompass) {
      const Vec3 p = from + (step * old.size) * (cosine * u + sine * w);
      const float equality = fan_equality(mesh, v, p);
      if (!(equality > best)) continue;
      best = equality;
      place = p;
    }
  }
  if (place == old.position) return;
  SurfacePoint moved = old;
  moved.position = place;
  if (!put_onto_surface(goal, kReach, moved)) return;
  if (!(fan_equality(mesh, v, moved.position) > before)) return;
  if (may_move(mesh, v, moved, std::min(kSine35, facing_fan_quality(mesh, v))))
    mesh.points[v] = moved;
}

}  // namespace

void equalise(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.is_there(v) && mesh.is_inner(v) && mesh.points[v].on_field)
        equalise_vertex(mesh, goal, v);
}

}  // namespace vasamesh

/// Moves towards equal edges.

#include <vector>

#include "stages/compass.h"
#include "stages/patch_clearance.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.1f;  // voxel lengths that the projection may move a vertex
constexpr float kSmallGain = 1e-3f;
constexpr float kEnough = 0.66f;  // squared edge ratio above which a triangle needs no more

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

/// Compass search across the normal of v for the place with the most equal edges.
Vec3 best_place(const PatchMesh& mesh, std::uint32_t v) {
  const SurfacePoint& old = mesh.points[v];
  Vec3 place = old.position;
  float best = fan_equality(mesh, v, place);
  if (best >= kEnough * static_cast<float>(mesh.fan_size(v)) - kSmallGain) return place;
  const auto [u, w] = tangents(old.normal);
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
  return place;
}

/// Whether v may go to its best place; `moved` is that place, on the surface where v is on it.
bool find_move(const PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v,
               SurfacePoint& moved) {
  const SurfacePoint& old = mesh.points[v];
  moved = old;
  moved.position = best_place(mesh, v);
  if (moved.position == old.position) return false;
  if (old.on_field && !put_onto_surface(goal, kReach, moved)) return false;
  return fan_equality(mesh, v, moved.position) > fan_equality(mesh, v, old.position) &&
         may_move(mesh, v, moved, std::min(kSine40, facing_fan_quality(mesh, v)));
}

}  // namespace

void equalise(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  std::vector<std::uint32_t> on_field, off_field;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.is_there(v) && mesh.is_inner(v))
      (mesh.points[v].on_field ? on_field : off_field).push_back(v);
  SurfacePoint moved;
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v : on_field)
      if (find_move(mesh, goal, v, moved)) mesh.points[v] = moved;
  if (off_field.empty()) return;
  Clearance clearance(mesh);
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v : off_field)
      if (find_move(mesh, goal, v, moved)) clearance.move_if_clear(mesh, v, moved);
}

}  // namespace vasamesh

/// Tangential smoothing.

#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.3f;     // voxel lengths that the projection may move a vertex
constexpr float kLargestStep = 0.5f;  // of the size

/// The mean of the centres of the triangles round v, weighted by area over squared size.
Vec3 fan_centre(const PatchMesh& mesh, std::uint32_t v) {
  const SurfacePoint& p = mesh.points[v];
  Vec3 sum;
  float weights = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const SurfacePoint& q = mesh.points[mesh.target(h)];
    const SurfacePoint& r = mesh.points[mesh.apex(h)];
    const Vec3 a = q.position - p.position, b = r.position - p.position;
    const float size = (p.size + q.size) + r.size;
    const float weight = norm(cross(a, b)) / (size * size);
    sum = sum + weight * (a + b);
    weights += 3 * weight;
  });
  return weights > 0 ? (1.0f / weights) * sum : Vec3{};
}

/// The mean normal of the triangles round v, by area.
Vec3 fan_normal(const PatchMesh& mesh, std::uint32_t v) {
  Vec3 sum;
  const Vec3& p = mesh.points[v].position;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    sum = sum + cross(mesh.points[mesh.target(h)].position - p,
                      mesh.points[mesh.apex(h)].position - p);
  });
  return normalised(sum);
}

/// Moves v where its fan is at least as good as before or good enough.
void smooth_vertex(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v) {
  if (!mesh.points[v].on_field) mesh.points[v].normal = fan_normal(mesh, v);
  const SurfacePoint old = mesh.points[v];
  Vec3 step = fan_centre(mesh, v);
  step = step - dot(step, old.normal) * old.normal;
  const float length = norm(step), most = kLargestStep * old.size;
  if (length > most) step = (most / length) * step;
  const float limit = std::min(kSine25, facing_fan_quality(mesh, v));
  for (float part : {1.0f, 0.5f}) {
    SurfacePoint moved = old;
    moved.position = old.position + part * step;
    if (old.on_field && !put_onto_surface(goal, kReach, moved)) continue;
    if (!may_move(mesh, v, moved, limit)) continue;
    mesh.points[v] = moved;
    return;
  }
}

}  // namespace

void smooth(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.is_there(v) && mesh.is_inner(v)) smooth_vertex(mesh, goal, v);
}

}  // namespace vasamesh

/// Tangential smoothing.

#include <vector>

#include "stages/patch_clearance.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.3f;        // voxel lengths that the projection may move a vertex
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

/// From a border vertex half the way to the middle between its neighbours on the border.
Vec3 border_step(const PatchMesh& mesh, std::uint32_t v) {
  std::uint32_t before = 0, after = PatchMesh::kNone;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    if (after == PatchMesh::kNone) after = mesh.target(h);
    before = mesh.apex(h);
  });
  const Vec3 middle = 0.5f * (mesh.points[before].position + mesh.points[after].position);
  return 0.5f * (middle - mesh.points[v].position);
}

/// The tangential part of the way to the fan's centre, on a border along it.
Vec3 smoothing_step(const PatchMesh& mesh, std::uint32_t v) {
  const SurfacePoint& p = mesh.points[v];
  Vec3 step = mesh.is_border(v) ? border_step(mesh, v) : fan_centre(mesh, v);
  step = step - dot(step, p.normal) * p.normal;
  const float length = norm(step), most = kLargestStep * p.size;
  return length > most ? (most / length) * step : step;
}

/// Moves v where its fan is at least as good as before or good enough.
void smooth_vertex(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v) {
  const SurfacePoint old = mesh.points[v];
  const Vec3 step = smoothing_step(mesh, v);
  const float limit = std::min(kSine25, facing_fan_quality(mesh, v));
  for (float part : {1.0f, 0.5f}) {
    SurfacePoint moved = old;
    moved.position = old.position + part * step;
    if (!put_onto_surface(goal, kReach, moved)) continue;
    if (!may_move(mesh, v, moved, limit)) continue;
    mesh.points[v] = moved;
    return;
  }
}

/// The same where the field was of no use: onto the surface if it is of use by now, else in the
/// mesh's own tangent plane; and only if no triangles come to meet.
void smooth_off_field(PatchMesh& mesh, const RemeshGoal& goal,
                      const std::vector<std::uint32_t>& vertices) {
  Clearance clearance(mesh);
  for (std::uint32_t v : vertices) {
    mesh.points[v].normal = fan_normal(mesh, v);
    SurfacePoint moved = mesh.points[v];
    const float limit = std::min(kSine25, facing_fan_quality(mesh, v));
    if (put_onto_surface(goal, kReach, moved) && may_move(mesh, v, moved, limit) &&
        clearance.move_if_clear(mesh, v, moved))
      continue;
    moved = mesh.points[v];
    moved.position = moved.position + smoothing_step(mesh, v);
    if (may_move(mesh, v, moved, limit)) clearance.move_if_clear(mesh, v, moved);
  }
}

}  // namespace

void smooth(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  std::vector<std::uint32_t> on_field, off_field;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.is_there(v) && mesh.is_whole(v))
      (mesh.points[v].on_field ? on_field : off_field).push_back(v);
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v : on_field) smooth_vertex(mesh, goal, v);
  if (!off_field.empty()) smooth_off_field(mesh, goal, off_field);
}

}  // namespace vasamesh

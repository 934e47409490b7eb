/// Vertices moved along their normals to where the triangles, and not they themselves, lie on the
/// surface.

#include <algorithm>
#include <vector>

#include "stages/patch_clearance.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.5f;       // voxel lengths from an edge's midpoint to the surface
constexpr int kSteps = 3;            // of the projection
constexpr float kMostOfSize = 0.2f;  // that a vertex is moved in a pass
constexpr float kLeast = 0.02f;      // voxel lengths that are worth a move

/// How far the surface lies outside of the midpoint between two points of it, voxel lengths.
bool find_gap(const FieldView& field, const SurfacePoint& a, const SurfacePoint& b, float& gap) {
  const Vec3 middle = 0.5f * (a.position + b.position);
  Vec3 foot = middle;
  if (!project_to_surface(field, kReach, kSteps, foot).known) return false;
  gap = dot(foot - middle, normalised(a.normal + b.normal));
  return true;
}

/// The mean gap over the fan of v, by area. A function that is quadratic over each triangle has its
/// mean over the surface in these midpoints alone.
float mean_gap(const PatchMesh& mesh, const FieldView& field, std::uint32_t v) {
  const SurfacePoint& p = mesh.points[v];
  float sum = 0, weights = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const SurfacePoint& q = mesh.points[mesh.target(h)];
    const Vec3 apex = mesh.points[mesh.apex(h)].position;
    const Vec3 across = mesh.points[mesh.apex(mesh.twin(h))].position;
    const Vec3 edge = q.position - p.position;
    const float weight =
        norm(cross(edge, apex - p.position)) + norm(cross(edge, across - p.position));
    float gap = 0;
    if (!find_gap(field, p, q, gap)) return;
    sum += weight * gap;
    weights += weight;
  });
  return weights > 0 ? sum / weights : 0.0f;
}

/// The inner vertices that the function says something of use about, but not those that relaxation
/// has moved.
std::vector<std::uint32_t> vertices_to_fit(PatchMesh& mesh, const FieldView& field) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.is_there(v) || !mesh.is_inner(v)) continue;
    SurfacePoint& point = mesh.points[v];
    if (!point.on_field && point.drift == 0) take_normal(field, point);
    if (point.on_field) vertices.push_back(v);
  }
  return vertices;
}

void move_along_normal(PatchMesh& mesh, std::uint32_t v, float move, Clearance& clearance) {
  SurfacePoint point = mesh.points[v];
  const float most = kMostOfSize * point.size;
  move = std::clamp(move, -most, most);
  if (!(move * move >= kLeast * kLeast)) return;
  point.position = point.position + move * point.normal;
  if (may_move(mesh, v, point, std::min(kSine25, facing_fan_quality(mesh, v))))
    clearance.move_if_clear(mesh, v, point);
}

}  // namespace

void fit(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  const std::vector<std::uint32_t> vertices = vertices_to_fit(mesh, goal.field);
  Clearance clearance(mesh);
  std::vector<float> moves(vertices.size());
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < vertices.size(); ++i)
      moves[i] = mean_gap(mesh, goal.field, vertices[i]);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      move_along_normal(mesh, vertices[i], moves[i], clearance);
  }
  for (const std::uint32_t v : vertices) mesh.points[v].on_field = false;
}

}  // namespace vasamesh

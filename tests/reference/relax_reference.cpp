#include "reference/relax_reference.h"

#include <algorithm>
#include <array>

#include "stages/compass.h"
#include "stages/patch_rules.h"

namespace vasamesh::test {

namespace {

/// Half the way to the middle between the neighbours along the border.
Vec3 along_border(const PatchMesh& mesh, std::uint32_t v) {
  std::uint32_t before = 0, after = PatchMesh::kNone;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    if (after == PatchMesh::kNone) after = mesh.target(h);
    before = mesh.apex(h);
  });
  const Vec3 middle = 0.5f * (mesh.points[before].position + mesh.points[after].position);
  return 0.5f * (middle - mesh.points[v].position);
}

/// To the mean of the triangles' centres by area over squared size.
Vec3 to_centre(const PatchMesh& mesh, std::uint32_t v) {
  const SurfacePoint& p = mesh.points[v];
  Vec3 sum;
  float weights = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const SurfacePoint &q = mesh.points[mesh.target(h)], &r = mesh.points[mesh.apex(h)];
    const Vec3 a = q.position - p.position, b = r.position - p.position;
    const float size = (p.size + q.size) + r.size;
    const float weight = norm(cross(a, b)) / (size * size);
    sum = sum + weight * (a + b);
    weights += 3 * weight;
  });
  return weights > 0 ? (1.0f / weights) * sum : Vec3{};
}

bool smooth_one(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v) {
  const SurfacePoint old = mesh.points[v];
  Vec3 step = mesh.is_border(v) ? along_border(mesh, v) : to_centre(mesh, v);
  step = step - dot(step, old.normal) * old.normal;
  if (norm(step) > 0.5f * old.size) step = (0.5f * old.size / norm(step)) * step;
  const float limit = std::min(kSquaredSine25, facing_fan_quality(mesh, v));
  for (float part : {1.0f, 0.5f}) {
    SurfacePoint moved = old;
    moved.position = old.position + part * step;
    if (!put_onto_surface(goal, 0.3f, moved) || !may_move(mesh, v, moved, limit)) continue;
    mesh.points[v] = moved;
    return true;
  }
  return false;
}

/// Sum of the squared edge ratios, each at most 0.66.
float equality(const PatchMesh& mesh, std::uint32_t v, const Vec3& p) {
  float sum = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const Vec3 &q = mesh.points[mesh.target(h)].position, &r = mesh.points[mesh.apex(h)].position;
    std::array<float, 3> edges = {squared_norm(q - p), squared_norm(r - q), squared_norm(p - r)};
    std::sort(edges.begin(), edges.end());
    if (edges[2] > 0) sum += std::min(edges[0] / edges[2], 0.66f);
  });
  return sum;
}

bool equalise_one(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v, bool onto) {
  const SurfacePoint old = mesh.points[v];
  SurfacePoint moved = old;
  float best = equality(mesh, v, old.position);
  if (best >= 0.66f * static_cast<float>(mesh.fan_size(v)) - 1e-3f) return false;
  const auto [u, w] = tangents(old.normal);
  for (float step : {0.08f, 0.04f}) {
    const Vec3 from = moved.position;
    for (const auto& [cosine, sine] : kCompass) {
      const Vec3 p = from + (step * old.size) * (cosine * u + sine * w);
      if (!(equality(mesh, v, p) > best)) continue;
      best = equality(mesh, v, p);
      moved.position = p;
    }
  }
  if (moved.position == old.position) return false;
  if (onto && !put_onto_surface(goal, 0.1f, moved)) return false;
  if (!(equality(mesh, v, moved.position) > equality(mesh, v, old.position))) return false;
  if (!may_move(mesh, v, moved, std::min(kSquaredSine40, facing_fan_quality(mesh, v))))
    return false;
  mesh.points[v] = moved;
  return true;
}

/// The mean way from the midpoints of the edges to the surface, by the areas beside them.
float gap_round(const PatchMesh& mesh, const FieldView& field, std::uint32_t v) {
  const SurfacePoint& p = mesh.points[v];
  float sum = 0, weights = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    const SurfacePoint& q = mesh.points[mesh.target(h)];
    const Vec3 middle = 0.5f * (p.position + q.position);
    Vec3 foot = middle;
    if (!project_to_surface(field, 0.5f, 3, foot).known) return;
    float weight = 0;
    for (std::uint32_t apex : {mesh.apex(h), mesh.apex(mesh.twin(h))})
      weight += norm(cross(q.position - p.position, mesh.points[apex].position - p.position));
    sum += weight * dot(foot - middle, normalised(p.normal + q.normal));
    weights += weight;
  });
  return weights > 0 ? sum / weights : 0.0f;
}

}  // namespace

std::vector<float> gaps_one_by_one(const PatchMesh& mesh, const FieldView& field) {
  std::vector<float> gaps(mesh.vertex_count(), 0.0f);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.is_there(v) && mesh.is_inner(v) && mesh.points[v].on_field)
      gaps[v] = gap_round(mesh, field, v);
  return gaps;
}

int smooth_one_by_one(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  int moves = 0;
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.is_there(v) && mesh.is_whole(v) && mesh.points[v].on_field)
        moves += smooth_one(mesh, goal, v);
  return moves;
}

int equalise_one_by_one(PatchMesh& mesh, const RemeshGoal& goal, int passes, bool onto) {
  int moves = 0;
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.is_there(v) && mesh.is_inner(v) && mesh.points[v].on_field)
        moves += equalise_one(mesh, goal, v, onto);
  return moves;
}

}  // namespace vasamesh::test

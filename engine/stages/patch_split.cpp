/// Splits of long edges, and the way onto the surface.

#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kMostDistance = 0.3f;  // voxel lengths

/// Whether the field's normal there is of use to a point with the normal `wanted`.
bool is_of_use(const FieldSample& sample, const Vec3& wanted, float slope) {
  return sample.known && slope >= kLeastSlope &&
         -dot(sample.gradient, wanted) >= kLeastAgreement * slope;
}

}  // namespace

void take_normal(const FieldView& field, SurfacePoint& point) {
  const FieldSample sample = sample_field(field, point.position);
  const float slope = norm(sample.gradient);
  point.on_field =
      is_of_use(sample, point.normal, slope) && std::abs(sample.value) <= kMostDistance * slope;
  if (point.on_field) point.normal = (-1 / slope) * sample.gradient;
}

bool put_onto_surface(const RemeshGoal& goal, float reach, SurfacePoint& point) {
  Vec3 position = point.position;
  const FieldSample sample = project_to_surface(goal.field, reach, kProjectionSteps, position);
  const float slope = norm(sample.gradient);
  if (!is_of_use(sample, point.normal, slope)) return false;
  point = {position, (-1 / slope) * sample.gradient, goal.size_at(position), 0, true};
  return true;
}

namespace {

/// How far an edge's midpoint may be from the surface: in voxel lengths, and of the edge.
constexpr float kReach = 0.3f, kReachOfEdge = 0.25f;

/// Whether both triangles of the edge, split at `point`, keep the rules.
bool splits_well(const PatchMesh& mesh, std::uint32_t h, const SurfacePoint& point) {
  const auto side = [&](std::uint32_t g) {
    const SurfacePoint& p = mesh.points[mesh.origin(g)];
    const SurfacePoint& q = mesh.points[mesh.target(g)];
    const SurfacePoint& c = mesh.points[mesh.apex(g)];
    return triangle_quality(p, point, c) >= kSquaredSine10 &&
           triangle_quality(point, q, c) >= kSquaredSine10;
  };
  const std::uint32_t t = mesh.twin(h);
  return side(h) && (t == PatchMesh::kNone || side(t));
}

}  // namespace

void split_long_edges(PatchMesh& mesh, const RemeshGoal& goal, float longest) {
  const std::uint32_t end = mesh.half_edge_end();
  for (std::uint32_t h = 0; h < end; ++h) {
    mesh.take_turn();
    if (!mesh.is_edge(h)) continue;
    const std::uint32_t t = mesh.twin(h), v = mesh.origin(h), w = mesh.target(h);
    if ((t != PatchMesh::kNone && t < h) || (!mesh.is_whole(v) && !mesh.is_whole(w))) continue;
    const SurfacePoint& p = mesh.points[v];
    const SurfacePoint& q = mesh.points[w];
    if (!(relative_length(p, q) > longest * longest)) continue;
    SurfacePoint middle = {0.5f * (p.position + q.position), normalised(p.normal + q.normal),
                           0.5f * (p.size + q.size), std::max(p.drift, q.drift),
                           p.on_field && q.on_field};
    const float reach = std::max(kReach, kReachOfEdge * norm(q.position - p.position));
    middle.on_field = middle.on_field && put_onto_surface(goal, reach, middle);
    if (splits_well(mesh, h, middle)) mesh.split(h, middle);
  }
}

}  // namespace vasamesh

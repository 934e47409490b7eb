/// Repair of the worst triangles.

#include <array>

#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.3f;  // voxel lengths that the projection may move a vertex
constexpr float kGain = 1.01f;  // the least by which a squared sine must grow

float quality_of(const PatchMesh& mesh, std::uint32_t h) {
  return triangle_quality(mesh.points[mesh.origin(h)], mesh.points[mesh.target(h)],
                          mesh.points[mesh.apex(h)]);
}

/// The least quality of the fan of `gone` once merged into `kept`.
float merged_quality(const PatchMesh& mesh, std::uint32_t gone, std::uint32_t kept) {
  float least = 1;
  mesh.for_each_out(gone, [&](std::uint32_t h) {
    const std::uint32_t b = mesh.target(h), c = mesh.apex(h);
    if (b == kept || c == kept) return;
    least = std::min(least, triangle_quality(mesh.points[kept], mesh.points[b], mesh.points[c]));
    if (!edge_follows(mesh.points[kept], mesh.points[b]) ||
        !may_replace(mesh.points[gone], mesh.points[kept], mesh.points[b], mesh.points[c], 0))
      least = -2;
  });
  return least;
}

bool try_collapse(PatchMesh& mesh, std::uint32_t h) {
  const std::uint32_t ends[2] = {mesh.origin(h), mesh.target(h)};
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t gone = ends[i], kept = ends[1 - i];
    if (!mesh.is_whole(gone) || !mesh.is_whole(kept)) continue;
    const float before = fan_quality(mesh, gone, mesh.points[gone]);
    if (!(merged_quality(mesh, gone, kept) > kGain * before)) continue;
    if (!mesh.may_collapse(h, gone, kept)) continue;
    mesh.collapse(h, gone, kept);
    return true;
  }
  return false;
}

bool try_flip(PatchMesh& mesh, std::uint32_t h) {
  const std::uint32_t t = mesh.twin(h);
  if (t == PatchMesh::kNone || !mesh.may_flip(h)) return false;
  const SurfacePoint& p = mesh.points[mesh.origin(h)];
  const SurfacePoint& q = mesh.points[mesh.target(h)];
  const SurfacePoint& c = mesh.points[mesh.apex(h)];
  const SurfacePoint& d = mesh.points[mesh.apex(t)];
  const float before = std::min(quality_of(mesh, h), quality_of(mesh, t));
  const float after = std::min(triangle_quality(d, c, p), triangle_quality(c, d, q));
  if (!(after > kGain * before) || !edge_follows(c, d)) return false;
  mesh.flip(h);
  return true;
}

/// Directions of a compass, as (cosine, sine).
constexpr std::array<std::array<float, 2>, 8> kCompass = {{{1, 0},
                                                           {0.70710678f, 0.70710678f},
                                                           {0, 1},
                                                           {-0.70710678f, 0.70710678f},
                                                           {-1, 0},
                                                           {-0.70710678f, -0.70710678f},
                                                           {0, -1},
                                                           {0.70710678f, -0.70710678f}}};

/// Two unit vectors across a unit normal.
std::array<Vec3, 2> tangents(const Vec3& normal) {
  const Vec3 axis = normal.x * normal.x < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalised(cross(normal, axis));
  return {u, cross(normal, u)};
}

/// Compass search for the place of v with the best fan.
bool try_move(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t v) {
  if (!mesh.is_inner(v)) return false;
  bool moved = false;
  float best = fan_quality(mesh, v, mesh.points[v]);
  for (float step = 0.2f; step > 0.02f;) {
    const SurfacePoint from = mesh.points[v];
    const auto [u, w] = tangents(from.normal);
    bool better = false;
    for (const auto& [cosine, sine] : kCompass) {
      SurfacePoint point = from;
      point.position = from.position + (step * from.size) * (cosine * u + sine * w);
      if (!(fan_quality(mesh, v, point) > best)) continue;
      if (from.on_field && !put_onto_surface(goal, kReach, point)) continue;
      const float quality = fan_quality(mesh, v, point);
      if (!(quality > best + 1e-4f) || !may_move(mesh, v, point, 0)) continue;
      best = quality;
      mesh.points[v] = point;
      better = true;
    }
    moved |= better;
    if (!better) step *= 0.5f;
  }
  return moved;
}

/// One try at a triangle: its shortest edge away, its longest turned, its corners moved.
void repair_triangle(PatchMesh& mesh, const RemeshGoal& goal, std::uint32_t first) {
  std::uint32_t shortest = first, longest = first;
  float least = 0, most = 0;
  for (std::uint32_t h = first; h < first + 3; ++h) {
    const float length = squared_norm(mesh.points[mesh.target(h)].position -
                                      mesh.points[mesh.origin(h)].position);
    if (h == first || length < least) least = length, shortest = h;
    if (h == first || length > most) most = length, longest = h;
  }
  const std::uint32_t corners[3] = {mesh.apex(longest), mesh.origin(longest), mesh.target(longest)};
  if (try_flip(mesh, longest) || try_collapse(mesh, shortest)) return;
  for (std::uint32_t v : corners)
    if (mesh.is_whole(v)) try_move(mesh, goal, v);
}

}  // namespace

std::uint32_t repair(PatchMesh& mesh, const RemeshGoal& goal, float wanted, int passes) {
  std::uint32_t left = 0;
  for (int pass = 0; pass <= passes; ++pass) {
    left = 0;
    for (std::uint32_t t = 0; t < mesh.half_edge_end(); t += 4) {
      if (!mesh.is_edge(t) || quality_of(mesh, t) >= wanted) continue;
      ++left;
      if (pass < passes) repair_triangle(mesh, goal, t);
    }
    if (left == 0) break;
  }
  return left;
}

}  // namespace vasamesh

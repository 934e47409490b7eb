#pragma once

/// \file
/// Mending of single triangles by a rule of geometry alone: an edge turned, or else the corners
/// moved, only where no triangle turns too far or comes to meet another.
///
/// A rule has
/// - is_poor(a, b, c): whether a triangle is to be mended;
/// - prefers_flip(p, q, c, d): whether the triangles d c p and c d q are better than p q c and
///   q p d;
/// - better_place(mesh, v): where the inner vertex v had better be, if anywhere;
/// - least_turn: the least cosine between a triangle before and after.

#include <cstdint>
#include <optional>

#include "stages/patch_clearance.h"
#include "stages/patch_mesh.h"
#include "types/vec3.h"

namespace vasamesh {

inline Vec3 area_vector(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
  return cross(b.position - a.position, c.position - a.position);
}

/// Whether the cosine between two vectors is below `least`, 0 or more, or no more than 0.
inline bool turns(const Vec3& before, const Vec3& after, float least) {
  const float cosine = dot(before, after);
  return !(cosine > 0 &&
           cosine * cosine >= least * least * squared_norm(before) * squared_norm(after));
}

inline float mean_edge(const PatchMesh& mesh, std::uint32_t v) {
  float sum = 0, count = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    sum += norm(mesh.points[mesh.target(h)].position - mesh.points[v].position);
    ++count;
  });
  return sum / count;
}

/// Search in all directions from the whole vertex v: takes(place) says whether a place is better
/// than all before it. Steps of 0.3 to `last_step` of the mean edge round v.
/// \return the best place.
template <class Takes>
SurfacePoint search_around(const PatchMesh& mesh, std::uint32_t v, float last_step,
                           const Takes& takes) {
  constexpr float kFirstStep = 0.3f;
  SurfacePoint best = mesh.points[v];
  const float edge = mean_edge(mesh, v);
  for (float step = kFirstStep; step > last_step;) {
    const Vec3 from = best.position;
    for (int i = 0; i < 27; ++i) {
      const Vec3 way = {static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1),
                        static_cast<float>(i / 9 - 1)};
      SurfacePoint point = best;
      point.position = from + (step * edge) * way;
      if (takes(point)) best = point;
    }
    if (best.position == from) step *= 0.5f;
  }
  return best;
}

template <class Rule>
bool may_turn_edge(const PatchMesh& mesh, const Rule& rule, std::uint32_t h) {
  const std::uint32_t t = mesh.twin(h);
  if (t == PatchMesh::kNone || !mesh.may_flip(h)) return false;
  const SurfacePoint &p = mesh.points[mesh.origin(h)], &q = mesh.points[mesh.target(h)],
                     &c = mesh.points[mesh.apex(h)], &d = mesh.points[mesh.apex(t)];
  if (!rule.prefers_flip(p, q, c, d)) return false;
  const Vec3 old = area_vector(p, q, c) + area_vector(q, p, d);
  return !turns(old, area_vector(d, c, p), rule.least_turn) &&
         !turns(old, area_vector(c, d, q), rule.least_turn);
}

/// One try at a triangle.
template <class Rule>
void mend_triangle(PatchMesh& mesh, const Rule& rule, std::uint32_t first, Clearance& clearance) {
  const std::uint32_t corners[3] = {mesh.origin(first), mesh.target(first), mesh.apex(first)};
  for (std::uint32_t h = first; h < first + 3; ++h)
    if (may_turn_edge(mesh, rule, h) && clearance.flip_if_clear(mesh, h)) return;
  for (const std::uint32_t v : corners) {
    if (!mesh.is_inner(v)) continue;
    if (const std::optional<SurfacePoint> place = rule.better_place(mesh, v))
      clearance.move_if_clear(mesh, v, *place);
  }
}

template <class Rule>
void mend_triangles(PatchMesh& mesh, const Rule& rule, int passes) {
  std::optional<Clearance> clearance;
  for (int pass = 0; pass < passes; ++pass) {
    bool any = false;
    for (std::uint32_t t = 0; t < mesh.half_edge_end(); t += 4) {
      mesh.take_turn();
      if (!mesh.is_edge(t) || !rule.is_poor(mesh.points[mesh.origin(t)],
                                            mesh.points[mesh.target(t)], mesh.points[mesh.apex(t)]))
        continue;
      if (!clearance) clearance.emplace(mesh);
      mend_triangle(mesh, rule, t, *clearance);
      any = true;
    }
    if (!any) return;
  }
}

}  // namespace vasamesh

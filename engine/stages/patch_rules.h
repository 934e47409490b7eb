#pragma once

/// \file
/// What a triangle and an edge of a surface that is being remeshed must be like, whatever operation
/// makes them.

#include <algorithm>
#include <cmath>

#include "stages/patch_mesh.h"
#include "types/vec3.h"

namespace vasamesh {

/// Squared sines of 10, 20, 25 and 40 degrees.
inline constexpr float kSquaredSine10 = 0.030154f, kSquaredSine20 = 0.116978f,
                       kSquaredSine25 = 0.178606f, kSquaredSine40 = 0.413176f;

/// Squared ratio of a triangle's shortest edge to its longest: 1 where they are equal, 0 where all
/// are points.
inline float squared_edge_ratio(const Vec3& p, const Vec3& q, const Vec3& r) {
  const float a = squared_norm(q - p), b = squared_norm(r - q), c = squared_norm(p - r);
  const float longest = std::max({a, b, c});
  return longest > 0 ? std::min({a, b, c}) / longest : 0.0f;
}

/// Of a triangle whose longest edge is 1.5 times its shortest.
inline constexpr float kLeastSquaredEdgeRatio = 1 / 2.25f;

/// Least cosine of the angle between a triangle and the surface at its corners.
inline constexpr float kLeastFacing = 0.5f;
/// The same for repairs.
inline constexpr float kLeastFacingInRepair = 0.25f;

/// Largest cosine of the angle between an edge and the normals at its ends: four edges round a
/// circle or more, and a chord less than a quarter of its length from the arc.
inline constexpr float kMostSlope = 0.75f;

/// Squared sine of a triangle's least angle, from its squared edge lengths and the squared norm of
/// the cross product of two of its edges. 0 for a degenerate triangle.
inline float least_squared_sine(float a, float b, float c, float squared_cross) {
  const float longest_two = std::max({a * b, b * c, c * a});
  return longest_two > 0 ? squared_cross / longest_two : 0.0f;
}

/// Squared sine of the triangle's least angle.
inline float least_squared_sine(const SurfacePoint& a, const SurfacePoint& b,
                                const SurfacePoint& c) {
  const Vec3 ab = b.position - a.position, bc = c.position - b.position,
             ca = a.position - c.position;
  return least_squared_sine(squared_norm(ab), squared_norm(bc), squared_norm(ca),
                            squared_norm(cross(ab, bc)));
}

/// Of the triangle of the half-edge h.
inline float least_squared_sine(const PatchMesh& mesh, std::uint32_t h) {
  return least_squared_sine(mesh.points[mesh.origin(h)], mesh.points[mesh.target(h)],
                            mesh.points[mesh.apex(h)]);
}

/// Squared sine of the triangle's least angle. Where it does not face as the surface at one of its
/// corners does (kLeastFacing), the cosine between them minus 1: below -0.5, the worse the lower.
inline float triangle_quality(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c,
                              float least_facing = kLeastFacing) {
  const Vec3 ab = b.position - a.position, bc = c.position - b.position,
             ca = a.position - c.position;
  const Vec3 normal = cross(ab, bc);
  const float squared_cross = squared_norm(normal);
  const float facing =
      std::min({dot(normal, a.normal), dot(normal, b.normal), dot(normal, c.normal)});
  if (!(facing > 0 && facing * facing >= least_facing * least_facing * squared_cross))
    return squared_cross > 0 ? facing / std::sqrt(squared_cross) - 1 : -2;
  return least_squared_sine(squared_norm(ab), squared_norm(bc), squared_norm(ca), squared_cross);
}

/// Whether the edge between two points follows the surface.
inline bool edge_follows(const SurfacePoint& a, const SurfacePoint& b) {
  const Vec3 edge = b.position - a.position;
  const float bound = kMostSlope * kMostSlope * squared_norm(edge);
  const float at_a = dot(edge, a.normal), at_b = dot(edge, b.normal);
  return at_a * at_a <= bound && at_b * at_b <= bound;
}

/// Squared length over the squared mean of the sizes at the ends.
inline float relative_length(const SurfacePoint& a, const SurfacePoint& b) {
  const float size = 0.5f * (a.size + b.size);
  return squared_norm(b.position - a.position) / (size * size);
}

/// The mean normal of the triangles round a whole vertex, by area.
inline Vec3 fan_normal(const PatchMesh& mesh, std::uint32_t v) {
  Vec3 sum;
  const Vec3& p = mesh.points[v].position;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    sum = sum +
          cross(mesh.points[mesh.target(h)].position - p, mesh.points[mesh.apex(h)].position - p);
  });
  return normalised(sum);
}

/// The triangles round a whole vertex: visit(b, c) with their other corners. Rings (fan_moves.h)
/// are fans too.
struct VertexFan {
  const PatchMesh& mesh;
  std::uint32_t vertex;

  template <class Visit>
  void for_each_triangle(const Visit& visit) const {
    mesh.for_each_out(vertex, [&](std::uint32_t h) {
      visit(mesh.points[mesh.target(h)], mesh.points[mesh.apex(h)]);
    });
  }
};

/// The least quality of the triangles of a fan with `point` in the middle.
template <class Fan>
float fan_quality(const Fan& fan, const SurfacePoint& point, float least_facing = kLeastFacing) {
  float least = 1;
  fan.for_each_triangle([&](const SurfacePoint& b, const SurfacePoint& c) {
    least = std::min(least, triangle_quality(point, b, c, least_facing));
  });
  return least;
}

/// The least quality of the triangles round p that face as the surface does.
template <class Fan>
float facing_quality(const SurfacePoint& p, const Fan& fan) {
  float least = 1;
  fan.for_each_triangle([&](const SurfacePoint& b, const SurfacePoint& c) {
    const float quality = triangle_quality(p, b, c);
    if (quality >= 0) least = std::min(least, quality);
  });
  return least;
}

inline float fan_quality(const PatchMesh& mesh, std::uint32_t v, const SurfacePoint& point,
                         float least_facing = kLeastFacing) {
  return fan_quality(VertexFan{mesh, v}, point, least_facing);
}

inline float facing_fan_quality(const PatchMesh& mesh, std::uint32_t v) {
  return facing_quality(mesh.points[v], VertexFan{mesh, v});
}

/// Whether `point` may take the place of `old` in a triangle with b and c: the quality is `limit`
/// or more, or the triangle faces wrongly already and comes to face less so.
inline bool may_replace(const SurfacePoint& old, const SurfacePoint& point, const SurfacePoint& b,
                        const SurfacePoint& c, float limit, float least_facing = kLeastFacing) {
  const float quality = triangle_quality(point, b, c, least_facing);
  if (quality >= limit) return true;
  const float before = triangle_quality(old, b, c, least_facing);
  return before < 0 && quality >= before;
}

/// Whether `point` may take the place of `old` in all triangles round it.
template <class Fan>
bool may_move(const SurfacePoint& old, const Fan& fan, const SurfacePoint& point, float limit,
              float least_facing = kLeastFacing) {
  bool good = true;
  fan.for_each_triangle([&](const SurfacePoint& b, const SurfacePoint& c) {
    good = good && may_replace(old, point, b, c, limit, least_facing);
  });
  return good;
}

/// Whether `point` may take the place of the whole vertex v.
inline bool may_move(const PatchMesh& mesh, std::uint32_t v, const SurfacePoint& point, float limit,
                     float least_facing = kLeastFacing) {
  return may_move(mesh.points[v], VertexFan{mesh, v}, point, limit, least_facing);
}

}  // namespace vasamesh

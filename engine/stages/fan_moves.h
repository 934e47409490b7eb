#pragma once

/// \file
/// Where smoothing and moves towards equal edges bring one vertex, from the ring round it. The
/// passes of all backends do this to the last bit.
///
/// Botsch, Kobbelt: A remeshing approach to multiresolution modeling, 2004; Dunyach, Vanderhaeghe,
/// Barthe, Botsch: Adaptive remeshing for real-time mesh deformation, 2013.

#include <cstdint>
#include <optional>
#include <span>

#include "stages/patch_passes.h"
#include "types/fans.h"

namespace vasamesh {

// How far projections may move a vertex, voxel lengths.
inline constexpr float kSmoothingReach = 0.3f, kEqualisingReach = 0.1f;
inline constexpr float kLargestStep = 0.5f;  // of smoothing, of the size
// The squared edge ratio above which a triangle's edges need not be more equal.
inline constexpr float kEnoughEquality = 0.66f;

/// A vertex's ring (FanView) among its points.
struct Ring {
  const SurfacePoint* points;
  std::span<const std::uint32_t> vertices;

  const SurfacePoint& operator[](std::size_t i) const { return points[vertices[i]]; }
  std::size_t triangles() const { return vertices.size() - 1; }
  bool is_border() const { return vertices.front() != vertices.back(); }

  template <class Visit>
  void for_each_triangle(const Visit& visit) const {
    for (std::size_t i = 0; i < triangles(); ++i) visit((*this)[i], (*this)[i + 1]);
  }
};

/// The tangential part of the way to the middle of the triangles round p, weighted by area over
/// squared size; on a border, half of that to the middle of its neighbours along it.
Vec3 smoothing_step(const SurfacePoint& p, const Ring& ring);

/// Moves p along its step, or half of it, onto the surface, if its triangles are at least as good
/// as before or good enough (patch_rules.h).
void smooth_vertex(const RemeshGoal& goal, const Ring& ring, SurfacePoint& p);

/// Whether p may go where the triangles round it have more equal edges, by a compass search across
/// its normal; `moved` is that place, put onto the surface if `onto` says so.
bool find_more_equal(const RemeshGoal& goal, const Ring& ring, const SurfacePoint& p, bool onto,
                     SurfacePoint& moved);

// From an edge's midpoint to the surface at most, voxel lengths, and the steps of the projection.
inline constexpr float kGapReach = 0.5f;
inline constexpr int kGapSteps = 3;

/// How far the surface lies outside of an edge's midpoint, voxel lengths; none where it is not
/// near. The same from both ends.
std::optional<float> edge_gap(const FieldView& field, const SurfacePoint& a, const SurfacePoint& b);

/// How far the surface lies outside of the triangles round an inner vertex, voxel lengths: at the
/// midpoints of its edges, the mean by the areas beside them. A function that is quadratic over
/// each triangle has its mean over the surface in these midpoints alone. Edges without the surface
/// near do not count; 0 where none has it.
/// \param gap_at  of i: the gap of the edge to the ring's vertex i.
template <class GapAt>
float mean_gap(const Ring& ring, const SurfacePoint& p, const GapAt& gap_at) {
  float sum = 0, weights = 0;
  Vec3 before = ring[ring.triangles() - 1].position;
  for (std::size_t i = 0; i < ring.triangles(); ++i) {
    const Vec3& place = ring[i].position;
    const Vec3 edge = place - p.position, after = ring[i + 1].position;
    const float weight =
        norm(cross(edge, after - p.position)) + norm(cross(edge, before - p.position));
    before = place;
    const std::optional<float> gap = gap_at(i);
    if (!gap) continue;
    sum += weight * *gap;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0.0f;
}

/// The ring of a fan, whose points are in the host's memory.
inline Ring ring_of(const FanView& fans, const SurfacePoint* points, std::size_t fan) {
  const std::uint32_t at = fans.ring_first[fan];
  return {points, {fans.ring.data() + at, fans.ring_first[fan + 1] - at}};
}

/// move(fan) for the fans of a part, in their order, `passes` times. The view is in the host's
/// memory too.
template <class Move>
void for_each_fan(const FanView& fans, std::size_t part, int passes, const Move& move) {
  const std::uint32_t first = fans.level_first[fans.part_level[part]],
                      end = fans.level_first[fans.part_level[part + 1]];
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t fan = first; fan < end; ++fan) move(fan);
}

}  // namespace vasamesh

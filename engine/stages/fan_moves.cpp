#include "stages/fan_moves.h"

#include <algorithm>

#include "stages/compass.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kSmallGain = 1e-3f;

/// How far the surface lies outside of the midpoint between two points of it, voxel lengths.
bool find_gap(const FieldView& field, const SurfacePoint& a, const SurfacePoint& b, float& gap) {
  const Vec3 middle = 0.5f * (a.position + b.position);
  Vec3 foot = middle;
  if (!project_to_surface(field, kGapReach, kGapSteps, foot).known) return false;
  gap = dot(foot - middle, normalised(a.normal + b.normal));
  return true;
}

/// The mean of the centres of the triangles round p, weighted by area over squared size.
Vec3 fan_centre(const SurfacePoint& p, const Ring& ring) {
  Vec3 sum;
  float weights = 0;
  for (std::size_t i = 0; i < ring.triangles(); ++i) {
    const SurfacePoint &q = ring[i], &r = ring[i + 1];
    const Vec3 a = q.position - p.position, b = r.position - p.position;
    const float size = (p.size + q.size) + r.size;
    const float weight = norm(cross(a, b)) / (size * size);
    sum = sum + weight * (a + b);
    weights += 3 * weight;
  }
  return weights > 0 ? (1.0f / weights) * sum : Vec3{};
}

/// From a border vertex half the way to the middle between its neighbours on the border.
Vec3 border_step(const SurfacePoint& p, const Ring& ring) {
  const Vec3 middle = 0.5f * (ring[ring.triangles()].position + ring[0].position);
  return 0.5f * (middle - p.position);
}

/// Sum over the triangles of the squared edge ratios, each at most kEnoughEquality.
float fan_equality(const Ring& ring, const Vec3& p) {
  float sum = 0;
  for (std::size_t i = 0; i < ring.triangles(); ++i)
    sum += std::min(edge_equality(p, ring[i].position, ring[i + 1].position), kEnoughEquality);
  return sum;
}

/// Compass search across the normal of p for the place with the most equal edges.
Vec3 most_equal_place(const SurfacePoint& p, const Ring& ring) {
  Vec3 place = p.position;
  float best = fan_equality(ring, place);
  if (best >= kEnoughEquality * static_cast<float>(ring.triangles()) - kSmallGain) return place;
  const auto [u, w] = tangents(p.normal);
  for (float step : {0.08f, 0.04f}) {
    const Vec3 from = place;
    for (const auto& [cosine, sine] : kCompass) {
      const Vec3 q = from + (step * p.size) * (cosine * u + sine * w);
      const float equality = fan_equality(ring, q);
      if (!(equality > best)) continue;
      best = equality;
      place = q;
    }
  }
  return place;
}

}  // namespace

Vec3 smoothing_step(const SurfacePoint& p, const Ring& ring) {
  Vec3 step = ring.is_border() ? border_step(p, ring) : fan_centre(p, ring);
  step = step - dot(step, p.normal) * p.normal;
  const float length = norm(step), most = kLargestStep * p.size;
  return length > most ? (most / length) * step : step;
}

void smooth_vertex(const RemeshGoal& goal, const Ring& ring, SurfacePoint& p) {
  const Vec3 step = smoothing_step(p, ring);
  const float limit = std::min(kSine25, facing_quality(p, ring));
  for (float part : {1.0f, 0.5f}) {
    SurfacePoint moved = p;
    moved.position = p.position + part * step;
    if (!put_onto_surface(goal, kSmoothingReach, moved)) continue;
    if (!may_move(p, ring, moved, limit)) continue;
    p = moved;
    return;
  }
}

bool find_more_equal(const RemeshGoal& goal, const Ring& ring, const SurfacePoint& p,
                     SurfacePoint& moved) {
  moved = p;
  moved.position = most_equal_place(p, ring);
  if (moved.position == p.position) return false;
  if (p.on_field && !put_onto_surface(goal, kEqualisingReach, moved)) return false;
  return fan_equality(ring, moved.position) > fan_equality(ring, p.position) &&
         may_move(p, ring, moved, std::min(kSine40, facing_quality(p, ring)));
}

float mean_gap(const FieldView& field, const Ring& ring, const SurfacePoint& p) {
  float sum = 0, weights = 0;
  Vec3 before = ring[ring.triangles() - 1].position;
  for (std::size_t i = 0; i < ring.triangles(); ++i) {
    const SurfacePoint& q = ring[i];
    const Vec3 edge = q.position - p.position, after = ring[i + 1].position;
    const float weight =
        norm(cross(edge, after - p.position)) + norm(cross(edge, before - p.position));
    before = q.position;
    float gap = 0;
    if (!find_gap(field, p, q, gap)) continue;
    sum += weight * gap;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0.0f;
}

}  // namespace vasamesh

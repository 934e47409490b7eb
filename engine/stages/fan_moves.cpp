#include "stages/fan_moves.h"

#include <algorithm>
#include <array>

#include "stages/compass.h"
#include "stages/patch_rules.h"
#include "types/least_most.h"

namespace vasamesh {

namespace {

constexpr float kSmallGain = 1e-3f;

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

/// A triangle's squared edge ratio, at most kEnoughEquality, from its squared edge lengths.
float enough_equality(float a, float b, float c) {
  const float longest = most(most(a, b), c);
  const float equality = least(least(a, b), c) / longest;
  return longest > 0 ? least(equality, kEnoughEquality) : 0.0f;
}

/// Sum over the triangles of the squared edge ratios, each at most kEnoughEquality.
float fan_equality(const Ring& ring, const Vec3& p) {
  float sum = 0, to_first = squared_norm(ring[0].position - p);
  for (std::size_t i = 0; i < ring.triangles(); ++i) {
    const Vec3 &q = ring[i].position, &r = ring[i + 1].position;
    const float to_second = squared_norm(r - p);
    sum += enough_equality(to_first, squared_norm(r - q), to_second);
    to_first = to_second;
  }
  return sum;
}

/// The same for each of the places.
CompassValues fan_equalities(const Ring& ring, const CompassPlaces& places) {
  const CompassPlaces at = places;
  CompassValues sum{}, to_last{};  // the first edge ends no triangle: adds nothing
  Vec3 last = ring[0].position;
  for (std::size_t i = 0; i <= ring.triangles(); ++i) {
    const Vec3 to = ring[i].position;
    const float across = squared_norm(to - last);
    for (std::size_t k = 0; k < kCompass.size(); ++k) {
      const float x = to.x - at.x[k], y = to.y - at.y[k], z = to.z - at.z[k];
      const float length = (x * x + y * y) + z * z;
      sum[k] += enough_equality(to_last[k], across, length);
      to_last[k] = length;
    }
    last = to;
  }
  return sum;
}

/// Compass search across the normal of p for the place with the most equal edges. \param before the
/// sum of the ratios at p.
Vec3 most_equal_place(const SurfacePoint& p, const Ring& ring, float before) {
  Vec3 place = p.position;
  if (before >= kEnoughEquality * static_cast<float>(ring.triangles()) - kSmallGain) return place;
  float best = before;
  const std::array<Vec3, 2> axes = tangents(p.normal);
  for (float step : {0.08f, 0.04f}) {
    const CompassPlaces places = compass_round(place, step * p.size, axes);
    const CompassValues equalities = fan_equalities(ring, places);
    for (std::size_t k = 0; k < kCompass.size(); ++k) {
      if (!(equalities[k] > best)) continue;
      best = equalities[k];
      place = places[k];
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
  const float limit = std::min(kSquaredSine25, facing_quality(p, ring));
  for (float part : {1.0f, 0.5f}) {
    SurfacePoint moved = p;
    moved.position = p.position + part * step;
    if (!put_onto_surface(goal, kSmoothingReach, moved)) continue;
    if (!may_move(p, ring, moved, limit)) continue;
    p = moved;
    return;
  }
}

bool find_more_equal(const RemeshGoal& goal, const Ring& ring, const SurfacePoint& p, bool onto,
                     SurfacePoint& moved) {
  moved = p;
  const float before = fan_equality(ring, p.position);
  moved.position = most_equal_place(p, ring, before);
  if (moved.position == p.position) return false;
  if (onto && !put_onto_surface(goal, kEqualisingReach, moved)) return false;
  return fan_equality(ring, moved.position) > before &&
         may_move(p, ring, moved, std::min(kSquaredSine40, facing_quality(p, ring)));
}

std::optional<float> edge_gap(const FieldView& field, const SurfacePoint& a,
                              const SurfacePoint& b) {
  const Vec3 middle = 0.5f * (a.position + b.position);
  Vec3 foot = middle;
  if (!project_to_surface(field, kGapReach, kGapSteps, foot).known) return std::nullopt;
  return dot(foot - middle, normalised(a.normal + b.normal));
}

}  // namespace vasamesh

#include "stages/expand_place.h"

#include <algorithm>

#include "stages/expand_rules.h"

namespace vasamesh {

using namespace expand_rules;

namespace {

/// Goes `length` along the surface from p in a tangent direction, and turns the direction with it.
bool walk(const FieldView& field, float length, Vec3& p, Vec3& direction) {
  const Vec3 start = p;
  p = p + length * direction;
  const FieldSample at = project_to_surface(field, kPlaceReach * length, kPlaceSteps, p);
  if (!at.known) return false;
  const Vec3 normal = normalised(at.gradient), gone = p - start;
  direction = normalised(gone - dot(gone, normal) * normal);
  return true;
}

}  // namespace

bool place_on_surface(const FieldView& field, const Vec3& from, const Vec3& direction, float length,
                      Vec3& place, Vec3& normal) {
  Vec3 p = from, along = direction;
  if (!walk(field, length, p, along)) {
    p = from;
    along = direction;
    if (!walk(field, 0.5f * length, p, along) || !walk(field, 0.5f * length, p, along))
      return false;
  }
  // What the bend took off the distance.
  place = from + (length / std::max(norm(p - from), 0.5f * length)) * (p - from);
  const FieldSample at = project_to_surface(field, kPlaceReach * length, kPlaceSteps, place);
  if (!at.known) return false;
  normal = -normalised(at.gradient);
  return true;
}

}  // namespace vasamesh

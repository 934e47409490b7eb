#pragma once

/// \file
/// Points of the surface at a given distance from another in a given direction.

#include "types/indicator_field.h"
#include "types/vec3.h"

namespace vasamesh {

/// A point of the zero set about `length` from `from`, a point of it with that outward normal, in
/// the tangent direction given. Where the surface bends so much that the tangent's end is too far
/// from it, the way is gone in two halves.
/// \return false where none is found.
bool place_on_surface(const FieldView& field, const Vec3& from, const Vec3& direction, float length,
                      Vec3& place, Vec3& normal);

}  // namespace vasamesh

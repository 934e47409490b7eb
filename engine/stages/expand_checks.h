#pragma once

/// \file
/// The rules that a triangle of the front must keep.

#include <array>
#include <span>

#include "stages/expand_grid.h"
#include "types/indicator_field.h"
#include "types/vec3.h"

namespace vasamesh {

/// Corners counter-clockwise seen from outside.
using Triangle = std::array<Vec3, 3>;

inline Vec3 unit_normal(const Triangle& t) { return normalised(cross(t[1] - t[0], t[2] - t[0])); }

/// Shortest over longest edge.
float edge_ratio(const Triangle& t);
float longest_edge(const Triangle& t);

/// Whether the triangle faces as the surface does at each of its corners. A sum of normals would
/// not do: round a tube of three edges it vanishes, and the tube would be capped.
bool faces_outward(const Triangle& t, const std::array<Vec3, 3>& normals);

/// Whether the edge follows the surface: its middle is within `off` times its length of the zero
/// set, and the gradient there is across the edge.
bool edge_on_surface(const FieldView& field, const Vec3& a, const Vec3& b, float off);

/// Whether a boundary edge of the same sheet runs through the triangle, both seen in the
/// triangle's plane. The triangle is taken a little smaller, so that touching at a corner or along
/// an edge does not count.
bool edge_crosses(const BoundaryEdge& edge, const Triangle& t);

}  // namespace vasamesh

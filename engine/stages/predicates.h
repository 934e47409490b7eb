#pragma once

/// \file
/// Exact geometric predicates on float32 coordinates. The only place that knows CGAL's kernel
/// (exact predicates, inexact constructions; LGPL).

namespace vasamesh {

/// Sign of dot(cross(b - a, c - a), d - a): positive when (a, b, c) is counter-clockwise seen from
/// d. Each points to three floats.
int orient3d(const float* a, const float* b, const float* c, const float* d);

/// Sign of the area of (a, b, c) projected along `axis` (0, 1 or 2): positive when
/// counter-clockwise in the coordinates (axis + 1, axis + 2), modulo 3.
int orient2d(const float* a, const float* b, const float* c, int axis);

/// Whether a, b, c lie on one line.
bool collinear(const float* a, const float* b, const float* c);

}  // namespace vasamesh

#pragma once

/// \file
/// The proof of a surface, in the coordinates in which it is written: closed, manifold, outward,
/// free of self-intersection, and of the topology of the segmentation that it came from. Works for
/// any triangle surface. The report's fields are described in vasamesh/report.h.

#include "backend/backend.h"
#include "stages/topology_count.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The solid that a surface must match, and where the surface lies in it.
struct SolidMatch {
  const Solid* solid = nullptr;
  Geometry geometry;
  Space space = Space::lps;
};

/// Examines `mesh`. Shells are joined by shared vertices; genus and shell counts say something
/// where edges and vertices are manifold. A shell inside an even number of others must face outward
/// (positive volume), inside an odd number inward. With `wanted`, an outward shell belongs to the
/// piece whose voxels lie in it, an inward one to that of the shell round it (pieces.h); a piece
/// matches when it has one outward shell, as many inward ones as cavities, and a genus sum
/// equal to its handles. A shell that belongs to no piece counts as a mismatch too.
///
/// \param wanted  may be null.
/// \throws Error bad_input, when a triangle names a vertex that is not there.
CheckReport check_surface(Backend& backend, const TriangleMesh& mesh, const SolidMatch* wanted);

}  // namespace vasamesh

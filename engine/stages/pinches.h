#pragma once

/// \file
/// Vertices and edges at which a surface touches itself.

#include "backend/backend.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Takes out the triangles with an edge that another triangle has in the same direction: no edge
/// has more than two triangles then, one a direction. The others stay in their order; vertices
/// stay. \return whether there were any.
bool drop_repeated_edges(const Backend& backend, TriangleMesh& mesh);

/// Gives each further fan of triangles at a vertex a vertex of its own, at the same place, so that
/// every vertex has one fan. New vertices go to the end, in the order of their lowest corners.
/// \pre no edge has more than two triangles.
void split_pinches(Backend& backend, TriangleMesh& mesh);

}  // namespace vasamesh

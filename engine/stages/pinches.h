#pragma once

/// \file
/// Vertices at which a surface touches itself.

#include "vasamesh/types.h"

namespace vasamesh {

/// Gives each further fan of triangles at a vertex a vertex of its own, at the same place, so that
/// every vertex has one fan. New vertices go to the end, in the order of their lowest corners.
/// \pre no edge has more than two triangles.
void split_pinches(TriangleMesh& mesh);

}  // namespace vasamesh

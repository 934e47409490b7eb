#pragma once

/// \file
/// Where one surface is too far from another: found run by run of its triangles, of which most are
/// near one triangle of the other surface as a whole.

#include <vector>

#include "backend/backend.h"
#include "stages/places.h"
#include "stages/triangle_tree.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Points of one surface that are farther than `limit` from another: its vertices, and the middles
/// of the edges of its triangles, quartered as often as is needed to leave out no part longer than
/// 0.2; in their unit, each once. Of triangles near the places alone, if there are any.
/// \pre the surface's vertices are finite, and the tree is that of its triangles, at least one.
std::vector<Vec3> points_beyond(Backend& backend, float limit, const TriangleMesh& from,
                                const TriangleMesh& to, const TriangleTree& tree,
                                const Places& places = {});

}  // namespace vasamesh

#pragma once

/// \file
/// Where a surface that was made from the base surface fails its proof.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/triangle_tree.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Whether every edge has one triangle on each side, and the Euler number is that of `base`. Pieces
/// and handles may differ all the same.
/// \pre no vertex of either is without a triangle, and the base surface is closed.
bool has_topology_of(Backend& backend, const TriangleMesh& base, const TriangleMesh& mesh);

/// Where the mesh is open, has an edge of several triangles or meets itself. Where none of these
/// explains its topology, where its angle defects are not the base surface's (angle_defects.h): of
/// such a cube the vertices of either surface that are farthest from the other.
/// \param meets_itself  whether to look for triangles that meet.
/// \param base_tree  of the base surface's triangles; both surfaces in voxel lengths.
std::vector<Vec3> find_defects(Backend& backend, const TriangleMesh& base,
                               const TriangleTree& base_tree, const TriangleMesh& mesh,
                               bool meets_itself);

}  // namespace vasamesh

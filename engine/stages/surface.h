#pragma once

/// \file
/// The base surface: marching tetrahedra of the relabelled cell lattice. Closed, manifold and of
/// the segmentation's topology by construction; every later surface is compared with it.

#include "backend/backend.h"
#include "types/lattice.h"
#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Vertices stay this part of an edge away from its nodes, so that rounding leaves no triangle
/// degenerate and none crossing another.
inline constexpr float kVertexMargin = 0.05f;

/// The surface in padded voxel units.
/// \throws Error refused, when its triangles have more than 2^32 corners.
TriangleMesh extract_base_surface(Backend& backend, const Lattice& lattice);

/// Takes vertices from padded voxel units to mm in the space that is asked for, in double, and
/// turns the triangles where the geometry (or the space) mirrors.
void place_in_space(Backend& backend, const Geometry& geometry, Space space, TriangleMesh& mesh);

}  // namespace vasamesh

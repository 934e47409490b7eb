#pragma once

/// \file
/// The segmentation's marching-cubes surface, from the cell lattice (types/marching_cube.h): what
/// distances from the segmentation are measured to.

#include "backend/backend.h"
#include "types/lattice.h"
#include "types/point_cloud.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The surface in voxel lengths (padded voxel units times `scale`): the centres of the faces between
/// object and background, in the order of their nodes, and the cubes' polygons. Programs cut
/// polygons that are not plane along different diagonals: all triangles of their corners are given,
/// so that any program's surface is part of this one. The triangles face neither in nor out.
TriangleMesh marching_cubes_of(Backend& backend, const Lattice& lattice, const Scale& scale);

}  // namespace vasamesh

#pragma once

/// \file
/// The segmentation's marching-cubes surface, from the cell lattice (types/marching_cube.h): what
/// distances from the segmentation are measured to.

#include "backend/backend.h"
#include "types/lattice.h"
#include "types/point_cloud.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Programs cut polygons that are not plane along different diagonals. Between the two meshes lies
/// the surface of any of them.
struct SolidSurface {
  TriangleMesh all;     ///< plane polygons as fans, of the others all triangles of their corners
  TriangleMesh common;  ///< plane polygons as fans, of the others the sides: triangles without area
};

/// The surface in voxel lengths (padded voxel units times `scale`): the centres of the faces
/// between object and background, in the order of their nodes (the vertices of both meshes), and
/// the cubes' polygons. The triangles face neither in nor out.
SolidSurface marching_cubes_of(Backend& backend, const Lattice& lattice, const Scale& scale);

}  // namespace vasamesh

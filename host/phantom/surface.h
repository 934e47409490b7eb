#pragma once

/// \file
/// The exact surface of a solid as a fine triangle mesh.

#include "phantom/solid.h"
#include "vasamesh/types.h"

namespace vasamesh::phantom {

/// The surface of `solid` inside the closed box `border`, where it is cut flat: closed, outward,
/// every vertex off the border within 1e-4 `step` of the solid's zero set, edges of about `step`
/// or less. Marching cubes on a lattice of that step; what is thinner may be lost. Coordinates are
/// those of the solid plus `shift`.
TriangleMesh exact_surface(const Shape& solid, const Eigen::AlignedBox3d& border, double step,
                           const Vec3& shift);

}  // namespace vasamesh::phantom

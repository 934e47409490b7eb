#pragma once

/// \file
/// Where two surfaces of about the same shape differ in topology, by the theorem of Gauss and
/// Bonnet: a handle or a hole that one of them lacks takes 4 pi from, or gives them to, the sum of
/// the angles that are missing from 2 pi at the vertices round it.

#include <vector>

#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The middles of the cubes (of 8 lengths, in two grids half a cube apart) in which the sums differ
/// by more than 2 pi, in the order of the cubes.
std::vector<Vec3> curvature_differences(const TriangleMesh& a, const TriangleMesh& b);

}  // namespace vasamesh

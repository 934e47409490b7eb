#pragma once

/// \file
/// Where two surfaces of about the same shape differ in topology, by the theorem of Gauss and
/// Bonnet: a handle or a hole that one of them lacks takes 4 pi from, or gives them to, the sum of
/// the angle defects round it, which are what is missing from 2 pi at the vertices.

#include <vector>

#include "backend/backend.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Side of the cubes, in the unit of the surfaces; they begin at the multiples of half of it.
inline constexpr float kAngleDefectCube = 8;

/// The middles of the cubes in which the sums differ by more than 3 pi, or where there is none by
/// more than 2 pi, since a tip alone has that much; of cubes that overlap the one with the largest
/// difference, which is the first.
std::vector<Vec3> angle_defect_differences(Backend& backend, const TriangleMesh& a,
                                           const TriangleMesh& b);

}  // namespace vasamesh

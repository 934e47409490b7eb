#pragma once

/// \file
/// Where small moves could make a part's sheets meet.

#include <cstdint>
#include <vector>

#include "stages/patch_mesh.h"

namespace vasamesh {

/// A byte a vertex: whether it lies off the field, or one that does lies near it, or one that faces
/// elsewhere and is more than two edges away. Near is 1.2 times the longest edge at either:
/// triangles without a crowded corner meet no others while their corners move by small parts of
/// their edges. \pre no coordinate is negative.
std::vector<std::uint8_t> crowded_vertices(const PatchMesh& mesh);

}  // namespace vasamesh

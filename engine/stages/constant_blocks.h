#pragma once

/// \file
/// Labels that were enlarged after they were made, as networks that work at a lower resolution
/// leave them: constant over blocks of voxels, so that their boundary has steps of a block.

#include <array>
#include <cstdint>

#include "stages/runs.h"

namespace vasamesh {

/// Voxels along each axis of the blocks over which the labels are constant, wherever the blocks
/// begin: the greatest common divisor of the distances between the places where labels change. 1
/// along an axis with too few of these to tell.
/// \param table  of the object's runs.
std::array<std::int64_t, 3> constant_blocks(const RunTable& table);

}  // namespace vasamesh

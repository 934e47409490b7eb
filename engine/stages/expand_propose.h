#pragma once

/// \file
/// What one corner of the front does next, and whether that is good.

#include <cstdint>
#include <vector>

#include "stages/expand_grid.h"
#include "types/front.h"
#include "types/sizes.h"

namespace vasamesh {

/// \param claimed  the corner's claim, which no other proposal of the round touches.
/// \param near     scratch.
Proposal propose(const FieldView& field, const SizeView& sizes, const FrontView& front,
                 const FrontLimits& limits, const CellBox& claimed, std::uint32_t corner,
                 std::vector<BoundaryEdge>& near);

}  // namespace vasamesh

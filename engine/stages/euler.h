#pragma once

/// \file
/// Euler characteristic of each piece of a solid, and its contacts over an edge or a corner, from
/// the 2 x 2 x 2 voxels round each corner of the voxel complex.
///
/// A corner's share of the characteristic is 1 (itself) - 1/2 for each edge + 1/4 for each face -
/// 1/8 for each voxel that touches it and is inside; eight times that is an integer, and it is 0
/// where all eight voxels are alike.

#include <array>
#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/runs.h"
#include "vasamesh/report.h"

namespace vasamesh {

struct CornerCounts {
  std::vector<std::int64_t> euler;  ///< a piece
  Finding edge_contacts;            ///< places in padded voxels
  Finding corner_contacts;
};

/// \param runs  the object's; \param piece  the piece of each run.
CornerCounts count_corners(Backend& backend, const BitView& object, const RunTable& runs,
                           const std::vector<std::int32_t>& piece, std::size_t piece_count,
                           int connectivity);

}  // namespace vasamesh

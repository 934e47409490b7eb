#pragma once

/// \file
/// Building brick tables: the octree without pointers.

#include <span>
#include <vector>

#include "backend/backend.h"
#include "types/bricks.h"

namespace vasamesh {

/// Bricks at the given coordinates, with their neighbour table.
/// \pre coords are unique and in raster order: by z, then y, then x.
Bricks make_bricks(Backend& backend, std::span<const BrickCoord> coords);

/// True where a comes before b in raster order.
bool raster_before(const BrickCoord& a, const BrickCoord& b);

/// Sorts into raster order and removes duplicates.
void sort_unique(std::vector<BrickCoord>& coords);

/// The bricks that lie within half a brick (four cells) of an octant that is set: each brick with
/// samples, and the neighbours on the sides of its set octants. In raster order.
/// octants[i] belongs to coords[i]: bit dx + 2 dy + 4 dz.
std::vector<BrickCoord> dilate_by_octants(std::span<const BrickCoord> coords,
                                          std::span<const std::uint8_t> octants);

}  // namespace vasamesh

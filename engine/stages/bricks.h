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

/// For each corner a table of side^3 entries, x fastest: the index in `bricks` (in raster order) of
/// the brick at corner + (0 .. side - 1) along each axis, or kNoBrick. side is 1 to 8.
Buffer<std::int32_t> brick_windows(Backend& backend, std::span<const BrickCoord> corners, int side,
                                   std::span<const BrickCoord> bricks);

/// The windows of three round each coordinate: its 27 neighbours in `bricks`.
Buffer<std::int32_t> neighbours_in(Backend& backend, std::span<const BrickCoord> coords,
                                   std::span<const BrickCoord> bricks);

/// True where a comes before b in raster order.
bool raster_before(const BrickCoord& a, const BrickCoord& b);

/// Sorts into raster order and removes duplicates.
void sort_unique(std::vector<BrickCoord>& coords);

/// The bricks that lie within half a brick (four cells) of an octant that is set: each brick with
/// samples, and the neighbours on the sides of its set octants. In raster order.
/// octants[i] belongs to coords[i]: bit dx + 2 dy + 4 dz.
std::vector<BrickCoord> dilate_by_octants(Backend& backend, std::span<const BrickCoord> coords,
                                          std::span<const std::uint8_t> octants);

}  // namespace vasamesh

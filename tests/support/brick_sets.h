#pragma once

/// \file
/// Sets of bricks, and fields on them, by fixed seeds.

#include <cstdint>
#include <vector>

#include "types/bricks.h"

namespace vasamesh {

/// `count` different bricks in raster order out of a box about twice as large, partly at negative
/// coordinates: most have some neighbours and lack others.
std::vector<BrickCoord> random_bricks(int count, std::uint32_t seed);

/// The bricks within one brick of a sphere round the origin, in raster order: the shape of a band.
std::vector<BrickCoord> shell_bricks(int radius);

/// Values in -1..1.
std::vector<float> random_floats(std::size_t count, std::uint32_t seed);

/// Values in -1..1 with zeros of both signs, sub-normals, and values of 1e-6 and 1e6 planted.
std::vector<float> awkward_floats(std::size_t count, std::uint32_t seed);

/// Zeros and ones, about one in four zero.
std::vector<std::uint8_t> random_mask(std::size_t count, std::uint32_t seed);

}  // namespace vasamesh

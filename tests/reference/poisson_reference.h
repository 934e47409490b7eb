#pragma once

/// \file
/// Slow plain oracle of the conjugate gradient's passes: cells are found by their coordinates in a
/// map, without neighbour tables or rows. The arithmetic is the contract's (engine/backend).

#include <array>
#include <cstdint>
#include <vector>

#include "types/bricks.h"

namespace vasamesh::reference {

/// One level: bricks in any order, their values 512 a brick.
struct Level {
  std::vector<BrickCoord> bricks;
  std::array<float, 3> weights;
};

/// A p where unknown, 0 elsewhere.
std::vector<float> poisson_apply(const Level& level, const std::vector<std::uint8_t>& unknown,
                                 const std::vector<float>& p);

/// Sums of a b, a brick an entry, in the contract's order.
std::vector<float> brick_sums(const std::vector<float>& a, const std::vector<float>& b);

/// The same in double precision, with the sum of the products' magnitudes, for what rounding may
/// do: the order does not matter there.
struct ExactSum {
  double sum = 0, magnitude = 0;
};
std::vector<ExactSum> exact_brick_sums(const std::vector<float>& a, const std::vector<float>& b);

}  // namespace vasamesh::reference

#pragma once

/// \file
/// A node's link in the cell lattice: 14 neighbours that form a sphere. A labelling of it is 14
/// bits, bit i the label of neighbour kLink[i].

#include <array>
#include <cstdint>

#include "types/lattice.h"

namespace vasamesh {

inline constexpr int kLinkCount = 1 << 14;

/// Connected parts among the neighbours in `members`.
int link_components(std::uint32_t members);

/// The part of `members` that is connected with its lowest neighbour.
std::uint32_t link_component(std::uint32_t members);

/// Which of the 2^14 labellings make the node simple: one part inside and one outside.
std::array<std::uint8_t, kLinkCount> make_simple_table();

}  // namespace vasamesh

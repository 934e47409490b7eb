#pragma once

/// \file
/// Filling tunnels and cavities that the smooth field does not have: where a homotopic relabelling
/// is stuck at a last node between the two ends of a tunnel, or in a cavity of one node.

#include <array>
#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/relabel.h"
#include "stages/topology_count.h"
#include "types/lattice.h"

namespace vasamesh {

/// Sets to inside, one after the other, those of the stuck nodes (outside, with a value above zero)
/// that fill a tunnel: a ring of inside nodes round them, and outside parts on both sides that are
/// joined elsewhere; or a cavity of one node. Never joins pieces and never makes a cavity.
/// \return how many, appended to `closings`.
std::size_t close_handles(Backend& backend, Lattice& lattice,
                          const std::array<std::vector<std::uint32_t>, 8>& stuck,
                          std::vector<Closing>& closings);

/// Takes the filled tunnels and cavities off what the surface must have, and counts them.
void take_off(const std::vector<Closing>& closings, Solid& solid, RelabelReport& report);

}  // namespace vasamesh

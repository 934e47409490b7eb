#pragma once

/// \file
/// Rounds of mesh expanding on plain arrays and loops: all against all, one after the other.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "types/front.h"
#include "types/sizes.h"

namespace vasamesh::test {

/// A front as plain arrays.
struct PlainFront {
  std::vector<FrontVertex> vertices;
  std::vector<FrontCorner> corners;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> listed;  ///< with dead corners, when a round begins
};

PlainFront plain_front(Backend& backend, const FrontView& front);

/// Measures the corners that changed, drops the dead from the list. \return the chosen corners:
/// those that come first of the five round them in the order of keys.
std::vector<std::uint32_t> choose_one_by_one(const FieldView& field, std::uint32_t round, bool wake,
                                             PlainFront& front);

/// Of each chosen corner, whether no cell that it claims is claimed by one with a higher key.
std::vector<bool> holders_one_by_one(const FieldView& field, const PlainFront& front,
                                     const std::vector<std::uint32_t>& chosen);

/// What each chosen corner proposes, nothing for those that hold no claim.
std::vector<Proposal> propose_one_by_one(const FieldView& field, const SizeView& sizes,
                                         const FrontLimits& limits,
                                         const std::vector<std::uint32_t>& chosen,
                                         const std::vector<bool>& holders, PlainFront& front);

/// Adds all of it, with the boundary as loops of corners that are cut, joined and extended.
void add_one_by_one(const std::vector<std::uint32_t>& chosen,
                    const std::vector<Proposal>& proposals, PlainFront& front);

}  // namespace vasamesh::test

#pragma once

/// \file
/// What a round of mesh expanding does with one corner. The passes of all backends do this to the
/// last bit; here on fronts in the host's memory, on many corners at the same time.

#include <cstdint>

#include "stages/expand_grid.h"
#include "types/front.h"
#include "types/indicator_field.h"

namespace vasamesh {

/// Rounds that have a key: the last of them is this one less one.
inline constexpr std::uint32_t kRoundsEnd = 4096;

/// Of a corner that changed, or of any when `wake`: measures its angle and finds the cell of its
/// edge. Gives it its key, and empties the list of the cell that its edge was in.
void measure_corner(const FieldView& field, const FrontView& front, std::uint32_t round, bool wake,
                    std::uint32_t corner);

/// Adds its edge to the list of its cell. \pre all corners have been measured.
void list_edge(const FrontView& front, std::uint32_t corner);

/// Whether it goes before its neighbours, two to each side: the higher key, then the higher index.
bool goes_first(const FrontView& front, std::uint32_t corner);

/// The box that a corner claims: what it changes must lie in it.
CellBox claimed_cells(const FieldView& field, const FrontView& front, std::uint32_t corner);

/// A claim of a corner: later rounds have higher ones, so that none needs to be taken back.
inline std::uint64_t claim_of(const FrontView& front, std::uint32_t corner) {
  return std::uint64_t{front.corners[corner].key} << 32 | corner;
}

/// Claims the cells of its box.
void claim_cells(const FieldView& field, const FrontView& front, std::uint32_t corner);

/// Whether it holds every cell that it claims.
bool holds_cells(const FieldView& field, const FrontView& front, std::uint32_t corner);

/// What a proposal of the corner adds: numbers of vertices, triangles and corners.
FrontStart needs_of(const FrontView& front, std::uint32_t corner, const Proposal& proposal);

/// Adds what the i-th of the chosen corners has proposed, at its start.
void add_proposal(const FieldView& field, const FrontView& front, std::size_t i);

}  // namespace vasamesh

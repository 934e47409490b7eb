#pragma once

/// \file
/// What one corner of the front does next, and whether that is good.

#include <array>
#include <cstdint>
#include <vector>

#include "stages/expand_front.h"
#include "stages/expand_grid.h"

namespace vasamesh {

/// What is asked of proposals; the last rounds ask for less.
struct FrontLimits {
  float join_reach = 0.65f;  ///< how far from its place a new vertex may be replaced, in edges
  float least_tau = 0.65f;   ///< shortest over longest edge of a triangle that adds no vertex
  float least_angle = 0.7f;  ///< radians: of a corner filled, and of what a fill may leave open
  float off_surface = 0.2f;  ///< of a new edge's length: its middle from the zero set
};

inline constexpr int kMostNewVertices = 4;

/// Triangles at one corner: its edges joined (ear), a fan of new vertices, or triangles to an
/// existing corner from its next edge, its previous one, or both.
struct Proposal {
  enum Kind : std::uint8_t { nothing, more_room, ear, fan, join_next, join_previous, join_both };
  Kind kind = nothing;
  std::uint8_t vertices = 0;  ///< new ones
  std::uint32_t corner = kNone, target = kNone;
  std::array<Vec3, kMostNewVertices> position, normal;
  std::array<float, kMostNewVertices> size;
};

/// Scratch of one task.
struct ProposalScratch {
  std::vector<BoundaryEdge> edges;
};

/// The box that a corner claims: what it changes must lie in it.
CellBox claimed_cells(const FieldView& field, const Front& front, std::uint32_t corner);

/// \param claimed  the corner's claim, which no other proposal of the round touches.
Proposal propose(const FieldView& field, const SizeView& sizes, const Front& front,
                 const EdgeGrid& grid, const VertexGrid& vertices, const FrontLimits& limits,
                 const CellBox& claimed, std::uint32_t corner, ProposalScratch& scratch);

}  // namespace vasamesh

#pragma once

/// \file
/// The moving front of mesh expanding in flat arrays that all backends share: vertices, triangles,
/// the corners of the boundary, what is near a place, and what a round proposes.

#include <cstdint>

#include "backend/buffer.h"
#include "types/vec3.h"

namespace vasamesh {

inline constexpr std::uint32_t kNoEntry = 0xffffffffu;

struct FrontVertex {
  Vec3 position, normal;               ///< the normal points outwards
  float size = 1;                      ///< edge length asked for
  std::uint32_t corners = 0;           ///< how many on the boundary; none inside
  std::uint32_t next_near = kNoEntry;  ///< the vertex after it in its cell's list
};

/// What a corner is about to do.
enum class CornerState : std::uint8_t {
  dead,     ///< no longer on the boundary
  changed,  ///< its angle is to be measured
  active,   ///< may propose
  frozen,   ///< had nothing to propose; wakes when its links change
};

/// A vertex on the boundary between the edges from its previous corner and to its next. The mesh
/// lies to the left of each edge, seen from outside.
struct FrontCorner {
  std::uint32_t vertex = kNoEntry, previous = kNoEntry, next = kNoEntry;
  float angle = 0;                     ///< the open side's, radians
  std::uint32_t key = 0;               ///< of the round: the higher goes first; 0 does not go
  std::uint32_t cell = kNoEntry;       ///< that lists its edge, the one to its next
  std::uint32_t next_near = kNoEntry;  ///< the corner after it in that list
  CornerState state = CornerState::changed;
  std::uint8_t wide = 0;  ///< it needs more room to propose
};

/// What is asked of proposals; the last rounds ask for less.
struct FrontLimits {
  float join_reach = 0.65f;  ///< how far from its place a new vertex may be replaced, in edges
  float least_tau = 0.65f;   ///< shortest over longest edge of a triangle that adds no vertex
  float least_angle = 0.7f;  ///< radians: of a corner filled, and of what a fill may leave open
  float off_surface = 0.2f;  ///< of a new edge's length: its middle from the zero set
};

inline constexpr int kCornerBlock = 512;     ///< corners of a list that a work-group takes
inline constexpr int kMostNewVertices = 4;   ///< of a proposal, and of its new corners
inline constexpr int kMostNewTriangles = 5;  ///< of a proposal

/// Triangles at one corner: its edges joined (ear), a fan of new vertices, or triangles to an
/// existing corner from its next edge, its previous one, or both.
struct Proposal {
  enum Kind : std::uint8_t { nothing, more_room, ear, fan, join_next, join_previous, join_both };
  Vec3 position[kMostNewVertices], normal[kMostNewVertices];
  float size[kMostNewVertices] = {};
  std::uint32_t target = kNoEntry;
  Kind kind = nothing;
  std::uint8_t vertices = 0;  ///< new ones
};

/// What a proposal adds, and then where that begins in the front's arrays.
struct FrontStart {
  std::uint32_t vertex = 0, triangle = 0, corner = 0;
};

struct FrontCounts {
  std::uint32_t vertices = 0, triangles = 0, corners = 0;
  std::uint32_t listed = 0, alive = 0, chosen = 0;  ///< entries of these lists
};

/// Cells are of 2 x 2 x 2 voxels, eight a brick of the field (stages/expand_grid.h), and one more
/// for all that lies outside of the bricks.
struct FrontView {
  View<FrontCounts> counts;       ///< one
  View<FrontVertex> vertices;     ///< with room for what a round adds, as are
  View<FrontCorner> corners;      ///< these,
  View<std::uint32_t> triangles;  ///< these, three vertices each, counter-clockwise from outside,
  View<std::uint32_t> listed;     ///< and these: the corners on the boundary, ascending, and some
                                  ///< that have died
  View<std::uint32_t> alive;      ///< room for the list without those
  View<std::uint32_t> chosen;     ///< room for the corners of the round, ascending
  View<Proposal> proposals;       ///< a chosen corner
  View<FrontStart> starts;        ///< a chosen corner
  View<std::uint64_t> claims;     ///< a cell: the highest claim ever, key << 32 | corner
  View<std::uint32_t> edge_at;    ///< a cell: the first corner of its list, or kNoEntry
  View<std::uint32_t> vertex_at;  ///< a cell: the first vertex of its list, or kNoEntry

  FrontVertex& vertex_of(std::uint32_t corner) const { return vertices[corners[corner].vertex]; }
  const Vec3& position_of(std::uint32_t corner) const { return vertex_of(corner).position; }
  const Vec3& normal_of(std::uint32_t corner) const { return vertex_of(corner).normal; }
  bool in_loop_of_three(std::uint32_t corner) const {
    return corners[corners[corners[corner].next].next].next == corner;
  }
};

}  // namespace vasamesh

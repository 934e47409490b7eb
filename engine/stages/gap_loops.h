#pragma once

/// \file
/// Gaps of a surface as closed loops of boundary edges, and how far each turns.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Loops of vertices, flat. A gap lies to the left of its edges, seen from outside: where a loop
/// goes from a to b, the surface has a triangle that goes from b to a. A vertex at which parts of
/// the surface touch appears once for each gap round it, be it in one loop or in several.
struct GapLoops {
  std::vector<std::uint32_t> first;   ///< loops + 1 entries
  std::vector<std::uint32_t> vertex;  ///< loop l: vertex[first[l]] .. vertex[first[l + 1] - 1]

  std::size_t count() const { return first.empty() ? 0 : first.size() - 1; }
  std::size_t size(std::size_t loop) const { return first[loop + 1] - first[loop]; }
  std::span<const std::uint32_t> operator[](std::size_t loop) const {
    return {vertex.data() + first[loop], size(loop)};
  }
  /// Adds a loop at the end.
  void add(std::span<const std::uint32_t> vertices);
};

/// The loops of a surface's boundary, by their lowest corner (vertex, then previous vertex), each
/// starting there. Where several fans of triangles meet at a vertex, each gap runs from a fan to
/// the next one counter-clockwise, so that the closed surface has one fan there.
/// \throws Error internal, where an edge has more than two triangles, or two of one direction.
GapLoops find_gap_loops(Backend& backend, const TriangleMesh& mesh);

/// The sum of the signed angles by which a loop turns to the left, each in the tangent plane of its
/// corner, in radians: 2 pi for a loop round a flat gap, 0 for one round a tube. Within 0.0001 a
/// corner. `points` and outward `normals`: one a corner.
float turning(std::span<const Vec3> points, std::span<const Vec3> normals);

}  // namespace vasamesh

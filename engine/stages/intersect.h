#pragma once

/// \file
/// Self-intersections of a triangle surface, by exact decisions: pairs of triangles that have more
/// in common than the vertices or the edge that they share by index. A pass of the backend finds
/// the candidates and dismisses nearly all of them (candidate_pairs.h); of the rest, separating
/// planes in double with an error bound (separating_planes.h) dismiss what they can, and exact
/// predicates decide.
///
/// Guigue, Devillers: Fast and robust triangle-triangle overlap test using orientation predicates,
/// 2003.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/triangle_tree.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

struct TrianglePair {
  std::uint32_t first, second;  ///< first < second
  bool operator==(const TrianglePair&) const = default;
};

struct Intersections {
  std::int64_t count = 0;
  std::vector<TrianglePair> pairs;  ///< the lowest ones, in order, at most kMostListed
  static constexpr std::size_t kMostListed = 1000;
};

/// Whether triangles `a` and `b` of the mesh meet beyond what they share by index; touching counts.
/// Neither may be degenerate.
bool triangles_intersect(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b);

/// A triangle of no mesh: its vertices, and where they are.
struct NamedTriangle {
  std::array<std::uint32_t, 3> vertex;
  std::array<const float*, 3> at;  ///< x, y, z
};

/// The same for two of these.
bool triangles_intersect(const NamedTriangle& a, const NamedTriangle& b);

/// The pairs that the backend's passes leave: all that intersect, and few others.
std::vector<TrianglePair> candidate_pairs(Backend& backend, const TriangleMesh& mesh,
                                          const TriangleTree& tree);

/// Every intersecting pair. Degenerate triangles and those with a vertex that is not finite take
/// no part: the tree leaves them out.
Intersections find_intersections(Backend& backend, const TriangleMesh& mesh,
                                 const TriangleTree& tree);

/// The middles of the pairs' six corners.
std::vector<Vec3> centres_of(const TriangleMesh& mesh, std::span<const TrianglePair> pairs);

}  // namespace vasamesh

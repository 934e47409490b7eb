#pragma once

/// \file
/// The rim of the gaps: their vertices, with the surface's normals there, and the edges that join
/// two of them already. A chord between vertices that have an edge would give it too many
/// triangles.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/gap_loops.h"
#include "types/indicator_field.h"

namespace vasamesh {

class GapRim {
 public:
  static constexpr std::uint32_t kNoVertex = 0xffffffffu;

  /// Normals come from the field, and from the triangles along the loops where it is not known.
  /// \throws Error internal, when an edge of a loop is not on the mesh's boundary.
  GapRim(Backend& backend, const FieldView& field, const TriangleMesh& mesh, const GapLoops& loops);

  /// Whether a triangle has the edge, in either direction. Both vertices must be in loops.
  bool has_edge(std::uint32_t a, std::uint32_t b) const;

  /// The third vertex of the triangle that goes from b to a: across the gap's edge from a to b.
  /// kNoVertex where there is none.
  std::uint32_t across(std::uint32_t a, std::uint32_t b) const;

  /// The surface's outward unit normal at a vertex of a loop.
  const Vec3& normal(std::uint32_t vertex) const { return normals_[slot_[vertex]]; }

  /// Adds an edge that the surface got since; `apex` as across(a, b) is to give it, may be
  /// kNoVertex.
  void add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t apex);

 private:
  /// From a rim vertex: to another one. `apex` belongs to the triangle that goes from `to` here.
  struct Spoke {
    std::uint32_t to, apex;
  };
  struct Added {
    std::uint32_t a, b, apex;
  };

  void number_vertices(const TriangleMesh& mesh, const GapLoops& loops);
  void collect_edges(Backend& backend, const TriangleMesh& mesh);
  void check_loops(Backend& backend, const GapLoops& loops) const;
  void find_normals(Backend& backend, const FieldView& field, const TriangleMesh& mesh);
  Vec3 normal_of_triangles(const TriangleMesh& mesh, std::size_t slot) const;

  std::vector<std::uint32_t> slot_;    ///< a vertex of the mesh: its place here, or kNoVertex
  std::vector<std::uint32_t> vertex_;  ///< a slot's vertex
  std::vector<Vec3> normals_;          ///< a slot
  std::vector<std::uint32_t> first_;   ///< slots + 1 entries
  std::vector<Spoke> spokes_;
  std::vector<Added> added_;  ///< few: joins of loops
};

}  // namespace vasamesh

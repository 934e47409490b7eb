#pragma once

/// \file
/// Whether triangles that an operation would make run into others of the part: a hashed grid of
/// its triangles' middles finds the candidates (few large ones are always looked at), exact
/// predicates decide (stages/intersect.h). And whether they would turn a small shell inside out
/// (stages/small_shells.h).

#include <cstdint>
#include <span>
#include <vector>

#include "stages/patch_mesh.h"
#include "stages/small_shells.h"
#include "types/box.h"
#include "types/cell_hash.h"

namespace vasamesh {

class Clearance {
 public:
  using Corners = PatchMesh::Corners;

  /// Takes up all triangles of the part.
  explicit Clearance(const PatchMesh& mesh);
  /// Takes up those with a vertex that is `wanted`, a byte a vertex.
  Clearance(const PatchMesh& mesh, std::span<const std::uint8_t> wanted);

  /// Whether the triangles `made` meet neither each other nor any triangle of the part but those of
  /// the half-edges `gone`, beyond the vertices and edges that they share; and a small shell keeps
  /// its volume.
  bool is_clear(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                std::span<const Corners> made);

  /// Takes up the triangle of the half-edge h as it is now, after any change of it.
  void take_up(const PatchMesh& mesh, std::uint32_t h);

  /// Turns the edge of h unless its new triangles would then meet others. \return whether it did.
  /// \pre mesh.may_flip(h)
  bool flip_if_clear(PatchMesh& mesh, std::uint32_t h);

  /// Moves the whole vertex v unless its triangles would then meet others. \return whether it did.
  bool move_if_clear(PatchMesh& mesh, std::uint32_t v, const SurfacePoint& point);

 private:
  template <class Wanted>
  void take_up_all(const PatchMesh& mesh, const Wanted& wanted);
  struct Entry {
    std::uint32_t face, next;
  };
  /// A triangle of the part (first half-edge / 4), as it was taken up.
  struct Face {
    Box box;
    std::uint32_t slot = PatchMesh::kNone;  ///< where it was entered last, or with the large ones
    std::uint32_t seen = 0;                 ///< the stamp of its last visit
  };
  struct Candidate {
    Corners corners;
    Box box;
  };

  void find_candidates(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                       const Box& around);
  void consider(const PatchMesh& mesh, std::uint32_t index, const Box& around);

  SmallShells shells_;
  CellHash cells_;
  float reach_ = 0;                  ///< no box in a slot has a longer half side
  std::vector<std::uint32_t> head_;  ///< a slot of the table: its first entry or kNone
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> large_;  ///< the triangles larger than a cell, in no slot
  std::vector<Face> faces_;
  std::uint32_t stamp_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> fan_;  ///< of the vertex that is moved: half-edges, triangles
  std::vector<Corners> fan_corners_;
};

}  // namespace vasamesh

#pragma once

/// \file
/// Whether triangles that an operation would make run into others of the part: a hashed grid of
/// its triangles finds the candidates, exact predicates decide (stages/intersect.h).
///
/// Teschner, Heidelberger, Mueller, Pomerantes, Gross: Optimized spatial hashing for collision
/// detection of deformable objects, 2003.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/patch_mesh.h"

namespace vasamesh {

class Clearance {
 public:
  using Corners = std::array<std::uint32_t, 3>;

  /// Takes up all triangles of the part.
  explicit Clearance(const PatchMesh& mesh);
  ~Clearance();
  Clearance(Clearance&&) noexcept;
  Clearance& operator=(Clearance&&) noexcept;

  /// Whether the triangles `made` meet neither each other nor any triangle of the part but those of
  /// the half-edges `gone`, beyond the vertices and edges that they share.
  bool is_clear(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                std::span<const Corners> made);

  /// Takes up the triangle of the half-edge h as it is now. Places where it was before stay in the
  /// grid, which costs time alone.
  void take_up(const PatchMesh& mesh, std::uint32_t h);

  /// Turns the edge of h unless its new triangles would then meet others. \return whether it did.
  /// \pre mesh.may_flip(h)
  bool flip_if_clear(PatchMesh& mesh, std::uint32_t h);

  /// Moves the whole vertex v unless its triangles would then meet others. \return whether it did.
  bool move_if_clear(PatchMesh& mesh, std::uint32_t v, const SurfacePoint& point);

 private:
  struct Entry {
    std::uint32_t face, next;
  };
  /// Cells of the grid, the last ones included; none to begin with.
  struct CellRange {
    std::array<std::uint32_t, 3> low{1, 1, 1}, high{};

    bool holds(const CellRange& other) const {
      bool all = true;
      for (std::size_t a = 0; a < 3; ++a)
        all = all && low[a] <= other.low[a] && other.high[a] <= high[a];
      return all;
    }
  };
  struct Box;
  struct Candidate;

  template <class Visit>
  void for_each_slot(const CellRange& cells, const Visit& visit) const;
  void find_candidates(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                       const Box& around);

  std::vector<std::uint32_t> head_;  // a slot of the table: its first entry or kNone
  std::vector<Entry> entries_;
  std::vector<CellRange> taken_;     // a face (first half-edge / 4): the cells that it is in
  std::vector<std::uint32_t> seen_;  // a face: the stamp of its last visit
  std::uint32_t stamp_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> fan_;  // of the vertex that is moved: half-edges, triangles
  std::vector<Corners> fan_corners_;
};

}  // namespace vasamesh

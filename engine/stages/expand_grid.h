#pragma once

/// \file
/// What is near a point: the boundary's edges, by the cells of their midpoints, and all vertices.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/expand_front.h"

namespace vasamesh {

/// The edge from a corner to its next.
struct BoundaryEdge {
  Vec3 start, end, normal;  ///< the normal at the start
  std::uint32_t corner = kNone;
};

class EdgeGrid {
 public:
  explicit EdgeGrid(const FieldView& field) : field_(field), head_(cell_count(field) + 1, kNone) {}

  /// Takes the edges of all corners that are alive, in place of those before.
  void build(Backend& backend, const Front& front);

  /// Appends the edges whose midpoints lie in the cells of a box, in a fixed order.
  void gather(const CellBox& box, std::vector<BoundaryEdge>& edges) const {
    for_cells(field_, box, [&](std::size_t cell) {
      for (std::uint32_t i = head_[cell]; i != kNone; i = next_[i]) edges.push_back(edges_[i]);
    });
  }

 private:
  const FieldView field_;
  std::vector<std::uint32_t> head_;         ///< a cell: its last edge
  std::vector<std::uint32_t> cell_, next_;  ///< an edge: its cell, and the one before it there
  std::vector<BoundaryEdge> edges_;         ///< by ascending corner
};

/// All vertices of the front, in a list a cell.
class VertexGrid {
 public:
  explicit VertexGrid(const FieldView& field)
      : field_(field), head_(cell_count(field) + 1, kNone) {}

  /// Takes the vertices that have come since.
  void update(const Front& front) {
    for (std::size_t v = next_.size(); v < front.position.size(); ++v) {
      std::uint32_t& head = head_[cell_index(field_, cell_at(field_, front.position[v]))];
      next_.push_back(head);
      head = static_cast<std::uint32_t>(v);
    }
  }

  /// Whether test(vertex) holds for a vertex within `reach` of p.
  template <class Test>
  bool any_near(const Front& front, const Vec3& p, float reach, const Test& test) const {
    bool found = false;
    for_cells(field_, cells_round(field_, p, reach), [&](std::size_t cell) {
      for (std::uint32_t v = head_[cell]; v != kNone && !found; v = next_[v])
        found = squared_norm(front.position[v] - p) < reach * reach && test(v);
    });
    return found;
  }

 private:
  const FieldView field_;
  std::vector<std::uint32_t> head_, next_;
};

}  // namespace vasamesh

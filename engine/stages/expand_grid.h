#pragma once

/// \file
/// Where the boundary's edges are: found by the cell of their midpoint.

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
  explicit EdgeGrid(const FieldView& field) : field_(field), first_(cell_count(field) + 2) {}

  /// Takes the edges of all corners that are alive.
  void build(Backend& backend, const Front& front);

  /// Appends the edges whose midpoints lie in the cells of a box, in a fixed order.
  void gather(const CellBox& box, std::vector<BoundaryEdge>& edges) const {
    for_cells(field_, box, [&](std::size_t cell) {
      edges.insert(edges.end(), edges_.begin() + first_[cell], edges_.begin() + first_[cell + 1]);
    });
  }

 private:
  const FieldView field_;
  std::vector<std::uint32_t> first_;  ///< a cell: its edges begin here; one more for no brick
  std::vector<std::uint32_t> cell_, place_;
  std::vector<BoundaryEdge> edges_;
};

}  // namespace vasamesh

#pragma once

/// \file
/// What is near a point: cells of 2 x 2 x 2 voxels, eight a brick of the field, that list the
/// boundary's edges by their midpoints and all vertices, and that corners claim.

#include <array>
#include <cstdint>
#include <vector>

#include "types/front.h"
#include "types/indicator_field.h"

namespace vasamesh {

/// The edge from a corner to its next.
struct BoundaryEdge {
  Vec3 start, end, normal;  ///< the normal at the start
  std::uint32_t corner = kNoEntry;
};

struct CellBox {
  std::array<int, 3> low, high;  ///< both included

  bool holds(const std::array<int, 3>& cell) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (cell[i] < low[i] || cell[i] > high[i]) return false;
    return true;
  }
};

inline std::array<int, 3> cell_at(const FieldView& field, const Vec3& p) {
  const float at[3] = {p.x * field.inverse_step[0], p.y * field.inverse_step[1],
                       p.z * field.inverse_step[2]};
  std::array<int, 3> cell;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto most = static_cast<float>(8 * field.grid[i] - 1);
    cell[i] = static_cast<int>(!(at[i] > 0) ? 0.0f : at[i] < most ? at[i] : most) >> 2;
  }
  return cell;
}

inline CellBox cells_round(const FieldView& field, const Vec3& p, float reach) {
  return {cell_at(field, {p.x - reach, p.y - reach, p.z - reach}),
          cell_at(field, {p.x + reach, p.y + reach, p.z + reach})};
}

inline std::size_t cell_count(const FieldView& field) {
  return field.coefficients.size / kBrickCells * 8;
}

/// The index of a cell; cell_count() where there is no brick.
inline std::size_t cell_index(const FieldView& field, const std::array<int, 3>& c) {
  const std::int32_t brick = field.brick_at[field.cell_of({c[0] >> 1, c[1] >> 1, c[2] >> 1})];
  if (brick == kNoBrick) return cell_count(field);
  return 8 * static_cast<std::size_t>(brick) +
         static_cast<std::size_t>((c[0] & 1) + 2 * (c[1] & 1) + 4 * (c[2] & 1));
}

/// Whether test(index of the cell) holds for one of the cells of a box that lie in bricks.
template <class Test>
bool any_cell(const FieldView& field, const CellBox& box, const Test& test) {
  for (int z = box.low[2]; z <= box.high[2]; ++z)
    for (int y = box.low[1]; y <= box.high[1]; ++y) {
      const std::int32_t* row = field.brick_at.data() + field.cell_of({0, y >> 1, z >> 1});
      const std::size_t side =
          2 * static_cast<std::size_t>(y & 1) + 4 * static_cast<std::size_t>(z & 1);
      for (int x = box.low[0]; x <= box.high[0]; ++x) {
        const std::int32_t brick = row[x >> 1];
        if (brick != kNoBrick &&
            test(8 * static_cast<std::size_t>(brick) + side + static_cast<std::size_t>(x & 1)))
          return true;
      }
    }
  return false;
}

/// visit(index of the cell) for the cells of a box that lie in bricks.
template <class Visit>
void for_cells(const FieldView& field, const CellBox& box, const Visit& visit) {
  any_cell(field, box, [&](std::size_t cell) {
    visit(cell);
    return false;
  });
}

/// Appends the edges whose midpoints lie in the cells of a box, in no certain order.
inline void gather_edges(const FieldView& field, const FrontView& front, const CellBox& box,
                         std::vector<BoundaryEdge>& edges) {
  for_cells(field, box, [&](std::size_t cell) {
    for (std::uint32_t c = front.edge_at[cell]; c != kNoEntry; c = front.corners[c].next_near) {
      const FrontVertex& start = front.vertex_of(c);
      edges.push_back({start.position, front.position_of(front.corners[c].next), start.normal, c});
    }
  });
}

/// Whether test(vertex) holds for a vertex within `reach` of p.
template <class Test>
bool any_near(const FieldView& field, const FrontView& front, const Vec3& p, float reach,
              const Test& test) {
  return any_cell(field, cells_round(field, p, reach), [&](std::size_t cell) {
    for (std::uint32_t v = front.vertex_at[cell]; v != kNoEntry; v = front.vertices[v].next_near)
      if (squared_norm(front.vertices[v].position - p) < reach * reach && test(front.vertices[v]))
        return true;
    return false;
  });
}

}  // namespace vasamesh

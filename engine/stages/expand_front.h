#pragma once

/// \file
/// The moving front of mesh expanding: vertices, triangles, and the boundary's corners.

#include <array>
#include <cstdint>
#include <vector>

#include "types/angles.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "types/vec3.h"

namespace vasamesh {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// What a corner is about to do.
enum CornerState : std::uint8_t {
  kDead,     ///< no longer on the boundary
  kChanged,  ///< its angle is to be measured
  kActive,   ///< may propose
  kFrozen,   ///< had nothing to propose; wakes when its links change
};

/// Flat arrays; a corner is a vertex on the boundary between the edges from its previous corner
/// and to its next. The mesh lies to the left of each edge, seen from outside.
struct Front {
  std::vector<Vec3> position, normal;    ///< a vertex; normals point outwards
  std::vector<float> size;               ///< a vertex: edge length asked for
  std::vector<std::uint8_t> corners;     ///< a vertex: how many on the boundary; none inside
  std::vector<std::uint32_t> triangles;  ///< three vertices each, counter-clockwise from outside

  std::vector<std::uint32_t> vertex, previous, next;  ///< a corner
  std::vector<float> angle;                           ///< a corner: the open side's, radians
  std::vector<CornerState> state;                     ///< a corner
  std::vector<std::uint8_t> wide;                     ///< a corner: it needs more room to propose
  std::vector<std::uint32_t> alive;                   ///< corners on the boundary, ascending

  const Vec3& at(std::uint32_t corner) const { return position[vertex[corner]]; }
  const Vec3& normal_at(std::uint32_t corner) const { return normal[vertex[corner]]; }
  bool in_loop_of_three(std::uint32_t corner) const { return next[next[next[corner]]] == corner; }

  std::uint32_t add_vertex(const Vec3& p, const Vec3& n, float h) {
    position.push_back(p);
    normal.push_back(n);
    size.push_back(h);
    corners.push_back(0);
    return static_cast<std::uint32_t>(position.size() - 1);
  }
  std::uint32_t add_corner(std::uint32_t at_vertex) {
    resize_corners(vertex.size() + 1);
    vertex.back() = at_vertex;
    ++corners[at_vertex];
    alive.push_back(static_cast<std::uint32_t>(vertex.size() - 1));
    return alive.back();
  }
  void link(std::uint32_t from, std::uint32_t to) {
    next[from] = to;
    previous[to] = from;
    state[from] = state[to] = kChanged;
  }
  void resize_corners(std::size_t count) {
    vertex.resize(count, kNone);
    previous.resize(count, kNone);
    next.resize(count, kNone);
    angle.resize(count, 0.0f);
    state.resize(count, kChanged);
    wide.resize(count, 0);
  }
  void resize_vertices(std::size_t count) {
    position.resize(count);
    normal.resize(count);
    size.resize(count);
    corners.resize(count, 0);
  }
  void kill(std::uint32_t corner) {
    state[corner] = kDead;
    --corners[vertex[corner]];
  }
};

/// The angle at `p` with the outward normal `n`, counter-clockwise from the direction of `from` to
/// that of `to` in the tangent plane: 0 to 2 pi.
inline float angle_between(const Vec3& p, const Vec3& n, const Vec3& from, const Vec3& to) {
  Vec3 a = from - p, b = to - p;
  a = a - dot(a, n) * n;
  b = b - dot(b, n) * n;
  return positive_angle(dot(a, b), dot(n, cross(a, b)));
}

/// Cells of 2 x 2 x 2 voxels, eight a brick of the field: where boundary edges are looked up, and
/// what corners claim.
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

/// visit(index of the cell) for the cells of a box that lie in bricks, in a fixed order.
template <class Visit>
void for_cells(const FieldView& field, const CellBox& box, const Visit& visit) {
  for (int z = box.low[2]; z <= box.high[2]; ++z)
    for (int y = box.low[1]; y <= box.high[1]; ++y)
      for (int x = box.low[0]; x <= box.high[0]; ++x) {
        const std::int32_t brick = field.brick_at[field.cell_of({x >> 1, y >> 1, z >> 1})];
        if (brick == kNoBrick) continue;
        visit(8 * static_cast<std::size_t>(brick) +
              static_cast<std::size_t>((x & 1) + 2 * (y & 1) + 4 * (z & 1)));
      }
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

}  // namespace vasamesh

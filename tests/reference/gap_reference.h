#pragma once

/// \file
/// The triangulation of a gap by looking at all of them, in double.

#include <cstdint>
#include <optional>

#include "stages/gap_rules.h"
#include "stages/triangulate_gap.h"

namespace vasamesh::test {

/// What a triangulation is judged by.
struct GapFigures {
  double least_angle = 0;   ///< radians
  double largest_turn = 0;  ///< the largest dihedral angle, 0 where flat, radians
  double area = 0;
  double cost = 0;  ///< the sum of triangle_cost
};

/// Figures of one triangulation, corners three a triangle.
GapFigures gap_figures(const GapPolygon& polygon, std::span<const std::uint16_t> triangles);

/// Whether it is a triangulation of the polygon that obeys chords and rules: n - 2 triangles,
/// every edge of the polygon once, every other edge twice, in opposite directions.
bool is_valid(const GapPolygon& polygon, const GapRules& rules,
              std::span<const std::uint16_t> triangles);

/// The best in the order (least angle, total cost) and in the order (least angle, largest turn,
/// area), angles told apart by more than 1e-5; none where no triangulation is valid.
struct BestGaps {
  GapFigures exact, paper;
  int valid = 0;  ///< triangulations that obey
};
std::optional<BestGaps> best_of_all(const GapPolygon& polygon, const GapRules& rules);

}  // namespace vasamesh::test

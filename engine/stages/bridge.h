#pragma once

/// \file
/// Loops made fit for triangulation: the two sides of an annulus are joined into one loop by a
/// bridge of two triangles, and long loops are split by short chords.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/gap_loops.h"
#include "stages/gap_rim.h"
#include "stages/gap_rules.h"
#include "types/angles.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// A loop that turns by less than this (radians) does not go round a disc.
inline constexpr float kLeastTurning = 0.9f * kPi;

/// Loops of more corners are split.
inline constexpr std::size_t kLongLoop = 128;

struct BridgedLoops {
  GapLoops loops;                        ///< in the order of their first loops
  std::vector<float> turning;            ///< of each loop
  std::vector<std::uint32_t> triangles;  ///< of the bridges: vertices of the mesh, three each
  std::int64_t bridges = 0;              ///< pairs of loops joined
  std::int64_t splits = 0;               ///< chords that split a loop
};

/// Joins each loop that turns by less than kLeastTurning to the nearest other one of its sheet,
/// again until it turns by more or no bridge obeys the rules; then splits loops longer than
/// kLongLoop by their shortest chord that leaves a quarter of the corners on either side, where
/// there is one. Joins and chords run over the gap alone, cross no other loop, and are added to
/// the rim. Decided in the order of the loops: the same at any number of threads.
BridgedLoops bridge_loops(Backend& backend, const TriangleMesh& mesh, const GapRules& rules,
                          const GapLoops& loops, GapRim& rim);

}  // namespace vasamesh

#pragma once

/// \file
/// Mesh expanding: triangles of the asked-for size, grown over the zero set of the indicator
/// function from seed hexagons and from patches that are meshed already.
///
/// The paper's front takes one edge from a queue at a time. Here the front moves in rounds, each
/// in parallel: corners of the boundary claim the cells round them, those that hold all they claim
/// propose triangles, and what is good is added, numbered by prefix sums. A corner is filled whole,
/// into parts of about 60 degrees (Hartmann: A marching method for the triangulation of surfaces,
/// 1998); near another part of the front it joins a vertex there, without which no surface but a
/// sphere could close. Corners, not vertices, carry the boundary: a vertex where the front touches
/// itself has several. The result is the same for any number of threads.

#include "backend/backend.h"
#include "stages/field.h"
#include "stages/gap_loops.h"
#include "stages/sizing.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The surface as far as the front got.
struct FrontResult {
  TriangleMesh mesh;  ///< voxel lengths; the patches' vertices and triangles first, unchanged

  /// The open boundary as gaps: to the left of each loop, which runs against the triangles' own
  /// edges. A vertex may come more than once, in one loop or in several.
  GapLoops loops;

  int rounds = 0;
  bool over_budget = false;  ///< stopped at three times the predicted triangles, or 1,000 rounds
};

/// \param patches  open or closed pieces in voxel lengths, as of hard regions; may be empty. Their
///                 edges belong to at most two triangles each.
/// \pre the backend's memory is the host's.
FrontResult expand(Backend& backend, const IndicatorField& field, const SizeField& sizes,
                   const TriangleMesh& patches);

}  // namespace vasamesh

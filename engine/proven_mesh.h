#pragma once

/// \file
/// The surface of a labelled lattice, proven in the coordinates in which it is asked for: no other
/// leaves the pipeline.

#include <array>

#include "scheduler.h"
#include "stages/topology_count.h"
#include "stages/verify.h"
#include "types/lattice.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The segmentation carried over to the cell lattice: what the surface must be, and where it runs.
struct Labelled {
  std::array<int, 3> size;  ///< padded voxels along each axis
  Scale scale;
  Solid solid;
  Lattice lattice;
};

/// The surface that is asked for; the base surface where no adaptive one is worthwhile or proven.
/// Its check and its making are in the report.
/// \throws Error failed_check, where none passes, or usage, where it cannot have the number of
///         triangles that is asked for.
TriangleMesh proven_mesh(const Labelled& labelled, const Parameters& parameters,
                         const SolidMatch& wanted, Scheduler& scheduler, Report& report);

}  // namespace vasamesh

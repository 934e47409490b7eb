#pragma once

/// \file
/// Gap stitching: the open boundary loops that mesh expanding leaves are closed by triangulations
/// that follow the surface, all gaps at once, and the patches refined to the density around them.
///
/// The paper's gap-stitching stage (eq. 6 and 7); triangulate_gap.h, bridge.h and refine_patch.h
/// name the sources of the parts.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/gap_loops.h"
#include "stages/triangulate_gap.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Why a gap stayed open.
enum class GapFailure {
  no_triangulation,  ///< nothing that was tried follows the surface
  edge_taken,        ///< other gaps have every edge that it could be closed by
  too_long           ///< more corners than the triangulation takes, and no chord splits it
};

/// A gap that is still open: the boundary loop as it now is, to the left of its edges.
struct OpenGap {
  std::vector<std::uint32_t> vertices;
  GapFailure reason = GapFailure::no_triangulation;
};

struct StitchReport {
  std::int64_t loops = 0;          ///< gaps that there were
  std::int64_t bridges = 0;        ///< pairs of loops joined, the sides of annuli
  std::int64_t splits = 0;         ///< chords that split a long loop
  std::int64_t relaxed = 0;        ///< gaps closed only after the rules were relaxed
  std::int64_t starred = 0;        ///< gaps closed by a vertex in their middle, for want of chords
  std::int64_t repeated = 0;       ///< triangulations done again, since two gaps wanted one edge
  std::size_t first_vertex = 0;    ///< vertices from here on were added
  std::size_t first_triangle = 0;  ///< triangles from here on were added
  std::vector<OpenGap> open;
};

/// Closes the gaps of a surface whose vertices lie on the field's zero set; positions in voxel
/// lengths. New vertices and triangles go to the end of the mesh; what was there stays. The same
/// bytes at any number of threads.
///
/// No edge gets more than two triangles. Triangles keep to within 60 degrees of the surface's
/// normals and chords to the surface, as far as that closes the gap, then farther
/// (close_gap.h). Gaps that cannot be closed so are reported, and stay open: as they were, or with
/// the bridge or chord that made them one side of a whole.
/// \param loops  the boundary's loops, as find_gap_loops gives them; loops of two corners are
///               passed over, since their edges are one.
/// \pre the field lies in the host's memory.
/// \throws Error internal, when an edge of a loop is not on the boundary.
StitchReport stitch_gaps(Backend& backend, const FieldView& field, const SizeView& sizes,
                         StitchMode mode, const GapLoops& loops, TriangleMesh& mesh);

/// The same, on all boundary loops of the mesh.
StitchReport stitch_gaps(Backend& backend, const FieldView& field, const SizeView& sizes,
                         StitchMode mode, TriangleMesh& mesh);

}  // namespace vasamesh

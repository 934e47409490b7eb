#pragma once

/// \file
/// Hard regions: where the front would lose the surface's topology, so that the base surface is
/// remeshed there instead. The vessel is thinner than an edge, another sheet is close, or the zero
/// set is not found.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/field.h"
#include "stages/sizing.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// One byte a triangle of the base surface (voxel lengths): 1 in a hard region. Decided for each
/// size cell that the surface passes: the radius of curvature is under 0.7 edge_min, a sign of the
/// function is wrong within 0.6 edge_min along the normal, or there is no zero set within reach;
/// and grown by three edge lengths. The hard triangles at a vertex are one fan, so that the
/// regions are surfaces with borders.
/// \pre the backend's memory is the host's.
std::vector<std::uint8_t> find_hard_regions(Backend& backend, const IndicatorField& field,
                                            const SizeField& sizes, const SizeRule& rule,
                                            const TriangleMesh& surface);

/// One byte a triangle: 1 for those with a flagged vertex (a byte a vertex), and for more, whose
/// vertices are flagged then, until the chosen triangles at each vertex are one fan.
std::vector<std::uint8_t> choose_triangles(Backend& backend, const TriangleMesh& surface,
                                           std::vector<std::uint8_t>& flagged);

}  // namespace vasamesh

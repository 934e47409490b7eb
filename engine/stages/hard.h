#pragma once

/// \file
/// Hard regions: where the front would lose the surface's topology, so that the base surface is
/// remeshed there instead. The vessel is thinner than an edge, another sheet is close, or the zero
/// set is not found.

#include <cstdint>
#include <span>
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
/// \param places  where the front has failed before: hard within two edges too.
/// \pre the backend's memory is the host's.
std::vector<std::uint8_t> find_hard_regions(Backend& backend, const IndicatorField& field,
                                            const SizeField& sizes, const SizeRule& rule,
                                            const TriangleMesh& surface,
                                            std::span<const Vec3> places = {});

}  // namespace vasamesh

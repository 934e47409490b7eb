#pragma once

/// \file
/// The shells of a surface against the pieces of a segmentation. From the centre of an object
/// voxel that lies in the surface's solid, the first triangle on a ray bounds the same connected
/// part of that solid; so does, for a cavity, the first one on a ray from its farthest vertex.
/// Pieces that meet in an edge or a corner are told apart as well as those far from each other.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/shells.h"
#include "stages/topology_count.h"
#include "stages/triangle_tree.h"
#include "stages/verify.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// How many pieces have another topology than their shells: one outward shell, as many inward ones
/// as cavities, a genus sum equal to the handles. Up to 9 voxels of each piece choose its outward
/// shell; where they do not agree, none lies in the solid, or two pieces choose one shell, the
/// pieces and the shells near them that are left must agree as two lists (thin pieces that touch
/// may leave the centres of their voxels). Shells of no piece count too.
/// \pre find_nesting has been called.
std::int64_t count_mismatches(Backend& backend, const TriangleMesh& mesh, const TriangleTree& tree,
                              const Shells& shells, const SolidMatch& match);

}  // namespace vasamesh

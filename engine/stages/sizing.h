#pragma once

/// \file
/// How long edges are to be, from the radius of curvature (eq. 5 of the paper):
/// h(p) = min over q of (clamp(rho r(q), edge_min, edge_max) + gradation |p - q|).
///
/// Sizes lie in the bricks of the indicator field at voxel resolution: 4 x 4 x 4 cells a brick.

#include "backend/backend.h"
#include "stages/field.h"
#include "types/sizes.h"
#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

struct SizeField {
  Buffer<float> sizes;  ///< 64 a brick of the field
  double predicted_triangles = 0;
};

/// What the sizes are made by, in voxel lengths.
struct SizeRule {
  float rho = 0.6f;  ///< edge length over radius of curvature
  float edge_min = 1.0f;
  float edge_max = 1.6f;
  float gradation = 0.25f;  ///< growth of the edge length a length
};

/// \param surface  the base surface, in voxel lengths: where the radii are taken.
SizeField make_sizes(Backend& backend, const IndicatorField& field, const TriangleMesh& surface,
                     const SizeRule& rule);

}  // namespace vasamesh

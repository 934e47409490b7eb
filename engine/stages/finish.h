#pragma once

/// \file
/// Finishing of a surface whose edges have the right lengths by and large: flips, tangential
/// smoothing and moves towards equal edges with re-projection, repair of the worst triangles until
/// the least angle holds, and the fit of the triangles to the surface. The topology stays; no
/// triangle turns away from the surface, and repairs run into no other triangle.

#include <span>

#include "backend/backend.h"
#include "stages/patch_blocks.h"
#include "stages/patch_passes.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// \param mesh  closed or with borders, manifold, in voxel lengths, counter-clockwise from outside.
/// \param places  if any: work near them alone, and not on vertices in those of factor 0.
TriangleMesh finish(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh, std::span<const CarefulPlace> places = {});

/// The same on a surface that is being remeshed.
void finish(Backend& backend, const RemeshGoal& goal, WorkingSurface& surface);

}  // namespace vasamesh

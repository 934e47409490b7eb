#pragma once

/// \file
/// The front's beginning and end: patches in, mesh and loops out.

#include "backend/backend.h"
#include "stages/expand.h"
#include "stages/expand_front.h"

namespace vasamesh {

/// A front that holds the patches, with a corner for each edge of their open boundary.
Front take_patches(Backend& backend, const FieldView& field, const SizeView& sizes,
                   const TriangleMesh& patches);

/// The mesh and the loops of the boundary.
FrontResult give_result(Front& front);

}  // namespace vasamesh

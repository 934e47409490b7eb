#pragma once

/// \file
/// Adaptive remeshing: a surface of any triangles becomes one whose edges have the lengths that are
/// asked for and whose triangles are close to equilateral, of the same topology by construction.
///
/// Botsch, Kobbelt: A remeshing approach to multiresolution modeling, 2004; Dunyach, Vanderhaeghe,
/// Barthe, Botsch: Adaptive remeshing for real-time mesh deformation, 2013.

#include "backend/backend.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Remeshes a closed surface or one with borders, in voxel lengths. Its vertices come onto the
/// field's zero set, where it is near; vertices of borders stay on their borders' lines.
/// \param mesh  manifold, without degenerate triangles, counter-clockwise from outside.
TriangleMesh remesh(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh);

}  // namespace vasamesh

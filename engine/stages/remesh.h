#pragma once

/// \file
/// Adaptive remeshing: a surface of any triangles becomes one whose edges have the lengths that are
/// asked for and whose triangles are close to equilateral, of the same topology by construction.
/// Rounds of splits, collapses, flips and tangential smoothing, each block of the surface by a task
/// of its own (patch_blocks.h); then moves towards equal edges and repair of the worst triangles.
///
/// Botsch, Kobbelt: A remeshing approach to multiresolution modeling, 2004; Dunyach, Vanderhaeghe,
/// Barthe, Botsch: Adaptive remeshing for real-time mesh deformation, 2013.

#include <span>

#include "backend/backend.h"
#include "stages/patch_passes.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Remeshes a closed surface or one with borders, in voxel lengths, to about the number of
/// triangles that its area and the sizes ask for. Vertices come onto the field's zero set where it
/// is near; borders move along the surface a little and keep six edges or more.
/// \param mesh  manifold, without degenerate triangles, counter-clockwise from outside; no
///              coordinate is negative.
/// \param places  may overlap: the least factor counts.
TriangleMesh remesh(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh, std::span<const CarefulPlace> places = {});

/// The same for patches whose surface is to be finished when it is whole.
TriangleMesh remesh_patches(Backend& backend, const FieldView& field, const SizeView& sizes,
                            const TriangleMesh& mesh, std::span<const CarefulPlace> places = {});

/// Remeshes a surface once more in the places, to their shorter edges; elsewhere it stays.
/// \param mesh  as for remesh().
TriangleMesh remesh_places(Backend& backend, const FieldView& field, const SizeView& sizes,
                           const TriangleMesh& mesh, std::span<const CarefulPlace> places);

}  // namespace vasamesh

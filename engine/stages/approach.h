#pragma once

/// \file
/// Brings a finished surface near points that it has left: chords over strongly curved places and
/// the tips of spurs, which the field's zero set alone does not hold. The edge next to such a point
/// is split, or its nearest vertex moved towards it, only where no triangle turns away from the
/// surface or comes to meet another, and no angle below 20 degrees is made; of what that leaves too
/// far, where none below 10 is. The topology stays.

#include <span>

#include "backend/backend.h"
#include "stages/places.h"
#include "stages/triangle_tree.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// \param mesh  closed, manifold, in voxel lengths, counter-clockwise from outside.
/// \param points  to which the surface shall come; few of them are away from it.
/// \param farthest  distance that a point may keep, above zero.
/// \return the mesh itself where no point is farther; some may stay so.
TriangleMesh approach(Backend& backend, const FieldView& field, const SizeView& sizes,
                      std::span<const Vec3> points, float farthest, TriangleMesh mesh);

/// Brings back, under the same rules, vertices that have gone astray from another surface.
/// \param origin  not empty; `tree` is that of its triangles.
/// \param farthest  distance from it that a vertex may keep, above zero.
/// \param within  if not empty: vertices near these places alone.
TriangleMesh bring_back(Backend& backend, const FieldView& field, const SizeView& sizes,
                        const TriangleMesh& origin, const TriangleTree& tree, float farthest,
                        TriangleMesh mesh, const Places& within = {});

}  // namespace vasamesh

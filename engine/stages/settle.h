#pragma once

/// \file
/// The last step of every adaptive surface: it is brought near the segmentation (approach.h), its
/// triangles of poor shape are mended (even_edges, widen_angles, open_dihedrals), and where it is
/// still too far or has small angles, it is remeshed there with shorter edges, and brought near
/// again.

#include <cstddef>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/solid_surface.h"
#include "stages/triangle_tree.h"
#include "types/indicator_field.h"
#include "types/sizes.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// What a surface must stay near to, in voxel lengths, with the trees of all triangles.
struct Bounds {
  const TriangleMesh& base;  ///< the base surface
  const TriangleTree& base_tree;
  const SolidSurface& solid;       ///< the segmentation's marching cubes
  const TriangleTree& solid_tree;  ///< of solid.common
  float limit = 0;                 ///< how far the surface and they may be from each other
};

struct Settled {
  TriangleMesh mesh;
  std::vector<Vec3> far;  ///< points of either that are too far from the other, all the same
};

/// \param mesh  closed, manifold, in voxel lengths, counter-clockwise from outside.
/// \param radius  of the places that are remeshed, voxel lengths.
/// \param within  if not empty: the places in which the mesh is new; elsewhere it has settled
///        before, and left `far`.
/// \param work  triangles that the tries may work on, counted once a try, of which none begins when
///        they are used up. What is left of them.
/// \return a surface of the same topology. Each place is as the best of several tries left it: with
///         the fewest triangles that meet, then the fewest points too far, then the fewest
///         triangles with angles below 10 and below 20 degrees. The worst places come first.
Settled settle(Backend& backend, const FieldView& field, const SizeView& sizes,
               const Bounds& bounds, float radius, TriangleMesh mesh,
               std::span<const CarefulPlace> within, const std::vector<Vec3>& far,
               std::size_t& work);

}  // namespace vasamesh

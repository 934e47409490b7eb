#pragma once

/// \file
/// Vertices of a surface that is being remeshed, and the fans of triangles round those that are to
/// be moved, in flat arrays.

#include <cstdint>

#include "types/buffer.h"
#include "types/vec3.h"

namespace vasamesh {

/// A vertex of a surface that is being remeshed; lengths in voxel lengths.
struct SurfacePoint {
  Vec3 position;
  Vec3 normal;      ///< outward unit normal: of the indicator function's level set, or of the mesh
  float size = 1;   ///< edge length that is asked for
  float drift = 0;  ///< voxel lengths that relaxation has moved it in all
  bool on_field = true;  ///< false where the function says nothing of use about the surface
};

/// Parts of a surface that have no vertices in common. A ring is the vertices round one, each
/// joined to the next by a triangle, counter-clockwise; where triangles are all round, it ends with
/// the vertex that it starts with, else the vertex is on a border. The vertices of a level have no
/// edges in common: each part's come level by level, and may be moved at the same time.
struct FanView {
  View<const std::uint32_t> part_level;   ///< parts + 1 entries: the part's first level
  View<const std::uint32_t> level_first;  ///< levels + 1 entries: the level's first fan
  View<const std::uint32_t> vertex;       ///< a fan: the vertex that is to be moved
  View<const std::uint32_t> ring_first;   ///< fans + 1 entries
  View<const std::uint32_t> ring;

  std::size_t parts() const { return part_level.size ? part_level.size - 1 : 0; }
};

}  // namespace vasamesh

#pragma once

/// \file
/// The vertices of a flat mesh as vectors.

#include <cstddef>

#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// \pre v is below mesh.vertex_count().
inline Vec3 vertex_at(const TriangleMesh& mesh, std::size_t v) {
  const float* p = mesh.vertices.data() + 3 * v;
  return {p[0], p[1], p[2]};
}

}  // namespace vasamesh

#pragma once

/// \file
/// Which triangles meet at each vertex, and which vertices hang together, in flat arrays.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The corners at vertex v are corner[first[v]] .. corner[first[v + 1] - 1], ascending; corner
/// 3 t + i is the i-th of triangle t.
struct VertexCorners {
  std::vector<std::uint32_t> first;  ///< vertices + 1 entries
  std::vector<std::uint32_t> corner;
};

/// All indices must be below the number of vertices. \throws Error refused beyond 2^32 corners.
VertexCorners vertex_corners(const Backend& backend, const TriangleMesh& mesh);

/// The lowest vertex that each vertex hangs together with by the chosen triangles (a byte a
/// triangle; all, if there are none).
std::vector<std::uint32_t> connect_vertices(Backend& backend, const TriangleMesh& mesh,
                                            std::span<const std::uint8_t> chosen = {});

}  // namespace vasamesh

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

  std::span<const std::uint32_t> at(std::uint32_t v) const {
    return std::span(corner).subspan(first[v], first[v + 1] - first[v]);
  }
};

/// All indices must be below the number of vertices. \throws Error refused beyond 2^32 corners.
VertexCorners vertex_corners(const Backend& backend, const TriangleMesh& mesh);

/// visit(c, d) for each edge from vertex v up to a vertex of higher index, w, that two triangles
/// share as those of a manifold do: v is corner c of the one that has v before w, and d of the
/// other.
template <class Visit>
void for_each_shared_edge_up(const TriangleMesh& mesh, const VertexCorners& corners,
                             std::uint32_t v, const Visit& visit) {
  const std::span<const std::uint32_t> round_v = corners.at(v);
  for (const std::uint32_t c : round_v) {
    const std::uint32_t w = mesh.triangles[c / 3 * 3 + (c + 1) % 3];
    if (w <= v) continue;
    for (const std::uint32_t d : round_v) {
      if (mesh.triangles[d / 3 * 3 + (d + 2) % 3] != w || c / 3 == d / 3) continue;
      visit(c, d);
      break;
    }
  }
}

/// The lowest vertex that each vertex hangs together with by the chosen triangles (a byte a
/// triangle; all, if there are none).
std::vector<std::uint32_t> connect_vertices(Backend& backend, const TriangleMesh& mesh,
                                            std::span<const std::uint8_t> chosen = {});

}  // namespace vasamesh

#pragma once

/// \file
/// Whether the triangles of a surface meet as those of a manifold do: at most two at an edge, in
/// opposite directions, and one fan round each vertex. Works vertex by vertex on the corners.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/adjacency.h"
#include "vasamesh/types.h"

namespace vasamesh {

struct ManifoldCounts {
  std::int64_t open_edges = 0;
  std::int64_t nonmanifold_edges = 0;
  std::int64_t misoriented_edges = 0;
  std::int64_t nonmanifold_vertices = 0;
  std::int64_t isolated_vertices = 0;
  std::vector<std::uint32_t> edges_up;  ///< a vertex: its edges to vertices of higher index
};

/// Triangles with a repeated vertex take no part.
ManifoldCounts count_manifold(Backend& backend, const TriangleMesh& mesh,
                              const VertexCorners& corners);

}  // namespace vasamesh

#pragma once

/// \file
/// Oracles of self-intersection by CGAL: the exact common part of each pair of triangles, and the
/// polygon mesh package's own search (GPL: tests alone may use it).

#include <vector>

#include "stages/intersect.h"
#include "vasamesh/types.h"

namespace vasamesh::test {

/// Whether two triangles, neither degenerate, have more in common than what they share by index:
/// their intersection is constructed in exact arithmetic.
bool intersect_exactly(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b);

bool is_degenerate(const TriangleMesh& mesh, std::uint32_t triangle);

/// All pairs of triangles, one by one.
std::vector<TrianglePair> all_exact_intersections(const TriangleMesh& mesh);

#ifdef VASAMESH_GPL_ORACLES
/// The pairs that CGAL's Polygon_mesh_processing finds; the mesh is manifold.
std::vector<TrianglePair> cgal_intersections(const TriangleMesh& mesh);
#endif

}  // namespace vasamesh::test

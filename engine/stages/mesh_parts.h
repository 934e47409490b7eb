#pragma once

/// \file
/// Parts of meshes: taken out, joined, and put back where they were.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Names the vertices anew that corners have, in the order in which they come first.
/// \pre corners are below `vertices`. \return their old names.
std::vector<std::uint32_t> rename_in_order(Backend& backend, std::size_t vertices,
                                           std::vector<std::uint32_t>& corners);

/// The chosen triangles of a mesh (a byte a triangle), and the vertices that they have, in the
/// order in which they come first.
TriangleMesh part_of(Backend& backend, const TriangleMesh& mesh,
                     const std::vector<std::uint8_t>& chosen);

/// Several parts at once. \param part  a byte a triangle: 0 where it is in none, i where it is in
/// the i-th of `count`; no two of them share a vertex.
std::vector<TriangleMesh> parts_of(const TriangleMesh& mesh, const std::vector<std::uint8_t>& part,
                                   std::size_t count);

/// One mesh and another, nothing shared.
TriangleMesh joined(TriangleMesh first, const TriangleMesh& second);

/// The mesh with other triangles in the place of the chosen ones. Vertices of `part` that lie
/// exactly where the chosen triangles meet the others are those of the mesh.
TriangleMesh with_part(Backend& backend, const TriangleMesh& mesh,
                       const std::vector<std::uint8_t>& chosen, const TriangleMesh& part);

}  // namespace vasamesh

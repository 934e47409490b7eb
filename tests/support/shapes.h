#pragma once

/// \file
/// Closed surfaces of known topology, area and volume, small and plain.

#include <array>

#include "vasamesh/types.h"

namespace vasamesh::test {

using Vertex = std::array<float, 3>;

std::uint32_t add_vertex(TriangleMesh& mesh, const Vertex& p);
void add_triangle(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c);

/// The mesh of both, with vertices of their own.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b);
TriangleMesh moved(TriangleMesh mesh, const Vertex& by);
TriangleMesh turned_inside_out(TriangleMesh mesh);

/// Right-angled, edges of length 1 from the origin, which is vertex 0.
TriangleMesh tetrahedron();

/// Eight vertices (x varies fastest), two triangles a side; side 2 a + s lies low or high along a.
TriangleMesh box(const Vertex& low, const Vertex& high);

/// 20 * 4^levels triangles with vertices on the sphere.
TriangleMesh sphere(float radius, int levels);

/// 2 * n * m triangles round the z axis; n the long way.
TriangleMesh torus(float large, float small, int n, int m);

}  // namespace vasamesh::test

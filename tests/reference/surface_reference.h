#pragma once

/// \file
/// Slow plain oracle of marching tetrahedra: every tetrahedron of the Freudenthal cut by itself,
/// its triangles turned by the values, corners told by their lattice edges.

#include <array>
#include <cstdint>
#include <vector>

#include "support/dense_volume.h"

namespace vasamesh::reference {

/// A vertex by the lattice edge that it lies on: the lower node and the higher.
using LatticeEdge = std::array<std::array<int, 3>, 2>;

/// Counter-clockwise from outside; the smallest edge first.
using EdgeTriangle = std::array<LatticeEdge, 3>;

/// The triangles of a labelled lattice, sorted. The outermost nodes are outside.
std::vector<EdgeTriangle> marching_tetrahedra(const test::DenseVolume& nodes);

/// The same triangle with its smallest edge first.
EdgeTriangle turned(const EdgeTriangle& triangle);

}  // namespace vasamesh::reference

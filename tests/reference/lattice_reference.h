#pragma once

/// \file
/// Slow plain oracles of the cell lattice: simple points by flood fill and counting, nodes told
/// from the voxels they touch, and the labelled nodes as one dense volume.

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "support/dense_volume.h"
#include "types/lattice.h"

namespace vasamesh::reference {

using test::DenseVolume;

/// Whether the labelling of the 14 nodes of a link makes its node simple: those inside span a
/// complex in the link that is connected and of Euler characteristic 1, thus without holes.
bool is_simple(std::uint32_t labels);

/// Whether node (x, y, z) is the centre of a face between an object voxel and background. Node and
/// voxels are those of types/lattice.h.
bool is_face_centre(const DenseVolume& volume, int x, int y, int z);

/// Whether a face centre lies within `radius` nodes along each axis.
bool near_face_centre(const DenseVolume& volume, const std::array<int, 3>& radius, int x, int y,
                      int z);

using NodePlaces = std::map<std::array<int, 3>, std::size_t>;

/// Whether Backend::lattice_mark_narrow marks the node at a place where all octants are active.
/// `state` and `values` have an entry a node.
bool is_narrow(const NodePlaces& nodes, const std::vector<std::uint8_t>& state,
               const std::vector<float>& values, const LeastWidths& least,
               const std::array<int, 3>& at);

/// `solid` (a label a node, of a padded volume) with the labels of the lattice's nodes in their
/// places.
DenseVolume relabelled(const DenseVolume& solid, const Lattice& lattice);

}  // namespace vasamesh::reference

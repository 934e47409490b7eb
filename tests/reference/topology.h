#pragma once

/// \file
/// Slow oracles of a segmentation's topology: flood fills over voxels and cells counted one by one,
/// and, independently, the simplices of the Freudenthal cut of the cell lattice.

#include <cstdint>
#include <vector>

#include "support/dense_volume.h"
#include "vasamesh/report.h"

namespace vasamesh::test {

/// Component of each voxel of `value` (0: background), numbered in raster order from 0; -1 for the
/// others. The volume is not padded.
std::vector<int> flood(const DenseVolume& volume, bool value, int connectivity);

/// Betti numbers from b0 and b2 by flood fills and the Euler characteristic by counting cells.
Topology count_cells(const DenseVolume& volume, int connectivity);

/// The same of each piece by itself, in raster order of first voxels.
std::vector<Topology> count_cells_by_piece(const DenseVolume& volume, int connectivity);

/// Which nodes of the cell lattice are inside: 2 n + 1 along each axis, odd ones inside voxels. A
/// node is a cell; it is inside by the rule of stages/topology_count.h, with the edges at a trimmed
/// corner trimmed too.
DenseVolume solid_labels(const DenseVolume& volume, int connectivity);

/// Betti numbers of the subcomplex of the Freudenthal cut that the nodes inside span. The outermost
/// nodes are outside.
Topology count_nodes(const DenseVolume& nodes);

/// count_nodes of solid_labels, the volume padded.
Topology count_lattice(const DenseVolume& volume, int connectivity);

}  // namespace vasamesh::test

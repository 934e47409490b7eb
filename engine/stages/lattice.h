#pragma once

/// \file
/// Topology by construction: the indicator function on the cell lattice, relabelled so that its
/// inside is homotopic to the segmentation.
///
/// A node is inside the solid when any voxel that it touches is object; under the Freudenthal cut
/// that labelling has the solid's topology. From it nodes are flipped towards the field's sign,
/// largest values first, each only while it is simple: its inside neighbours in the link are
/// connected and so are its outside ones (Bertrand and Malandain, "A new characterization of
/// three-dimensional simple points", 1994, carried over to the 14-neighbour lattice). Nodes of one
/// colour (parities of x, y, z) do not see one another and flip at once. Where nodes are stuck, or
/// the labels leave the segmentation too far, the field is led back to it and the rest repeated.

#include <array>
#include <cstdint>

#include "backend/backend.h"
#include "scheduler.h"
#include "types/lattice.h"
#include "types/octree.h"
#include "types/volume.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"

namespace vasamesh {

/// Which of the 2^14 labellings of a link make its node simple: bit i is the label of neighbour i.
inline constexpr int kLinkCount = 1 << 14;
std::array<std::uint8_t, kLinkCount> make_simple_table();

/// How far a surface may be from the segmentation's marching cubes, in voxel lengths: the larger
/// of the smallest spacing and 0.55 of the largest.
float distance_limit(const Scale& scale);

/// The bricks of nodes near the boundary, with the solid's labels and the field's values.
Lattice build_lattice(Backend& backend, const BitVolume& object, const PointCloud& points,
                      const Scale& scale, const Octree& octree, const Parameters& parameters);

/// Relabels and repairs; afterwards every value's sign is its node's label, and the labels are
/// homotopic to the solid.
RelabelReport relabel(Scheduler& scheduler, const Scale& scale, Lattice& lattice);

}  // namespace vasamesh

#pragma once

/// \file
/// Topology by construction: the lattice's labels, moved from the solid's to the field's sign by
/// homotopic flips.
///
/// Nodes are flipped towards the sign of the field, largest values first, each only while it is
/// simple: its inside neighbours in the link are connected and so are its outside ones (Bertrand
/// and Malandain, "A new characterization of three-dimensional simple points", 1994, carried over
/// to the 14-neighbour lattice). Nodes of one colour (parities of x, y, z) do not see one another
/// and flip at once. Where nodes are stuck, where the labels leave the segmentation too far, or
/// where the field makes narrower than marching cubes would what the topology keeps (vessels of a
/// voxel beside thick ones, specks, cavities), the field is led back to the segmentation and the
/// rest repeated.

#include <array>
#include <vector>

#include "scheduler.h"
#include "types/lattice.h"
#include "types/point_cloud.h"
#include "vasamesh/report.h"

namespace vasamesh {

/// A tunnel or a cavity of the solid that was filled on purpose.
struct Closing {
  bool tunnel = true;
  std::array<int, 3> node{0, 0, 0};  ///< the node that closed it, in lattice coordinates
};

/// Relabels and repairs; afterwards every value's sign is its node's label, and the labels are
/// homotopic to the solid. With `closings` not null, tunnels and cavities of the solid that the
/// field does not have are filled and listed there, and the labels are homotopic to what remains.
RelabelReport relabel(Scheduler& scheduler, const Scale& scale, Lattice& lattice,
                      std::vector<Closing>* closings);

}  // namespace vasamesh

#pragma once

/// \file
/// The marching-cubes surface of a segmentation at 0.5: the reference of distances where no better
/// one is known.

#include "io/volume_reader.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The surface in mm, LPS, outward; the volume's border is closed by background. Its topology need
/// not be the segmentation's. \throws Error bad_input, when nothing is in the foreground.
TriangleMesh marching_cubes(const Segmentation& segmentation);

}  // namespace vasamesh

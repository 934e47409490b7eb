#pragma once

/// \file
/// How many bytes a conversion will hold, known once its boundary is.

#include <cstddef>

#include "types/volume.h"

namespace vasamesh {

/// Bounds of the most that the backends' buffers hold at a time.
struct BytePlan {
  std::size_t least = 0, most = 0;
};

/// The bit-packed volume stays until the field is solved for, and every sample brings its share of
/// octree, lattice and surface: 450 to 1140 bytes on fifteen phantoms of more than a thousand
/// samples, by how far apart these lie.
BytePlan plan_bytes(const BitView& object, std::size_t points);

}  // namespace vasamesh

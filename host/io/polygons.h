#pragma once

/// \file
/// Polygons of surface files, cut into triangles.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "vasamesh/types.h"

namespace vasamesh {

/// A surface as a file lists it, its polygons cut into fans round their first corners. Where such a
/// fan is wrong is seen once all vertices are there.
struct FannedMesh {
  struct Fan {
    std::size_t first, count;  ///< triangles
  };

  /// Less than three corners are nothing.
  void append(std::span<const std::uint32_t> corners);

  TriangleMesh mesh;
  std::vector<Fan> fans;  ///< of more than three corners
};

/// Cuts polygons anew whose fans turn round, as those of concave ones do, by VTK's search for ears.
/// What that cannot cut, as crossing itself or having no area, stays a fan, and so do polygons of
/// more than 2^14 corners: the search takes the square of their number.
/// \pre all corners are in range, all coordinates finite.
void cut_polygons(FannedMesh& surface);

}  // namespace vasamesh

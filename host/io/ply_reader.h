#pragma once

/// \file
/// Triangles of a PLY file (G. Turk, The PLY Polygon File Format, 1994). VTK's reader follows
/// indices that are out of range into memory that is not its own.

#include <string>

#include "io/polygons.h"

namespace vasamesh {

/// Text or binary of either byte order; properties x, y, z of element "vertex" and the list
/// "vertex_indices" (or "vertex_index") of element "face"; all else is skipped.
/// \throws Error bad_input: not such a file, truncated, vertices without x, y or z, triangles in
///         strips, a negative or non-integral index.
FannedMesh read_ply(const std::string& path);

}  // namespace vasamesh

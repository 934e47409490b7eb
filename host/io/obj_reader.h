#pragma once

/// \file
/// Triangles of a Wavefront OBJ file. VTK's reader gives each corner with its own texture or normal
/// a vertex of its own, which tears a closed surface open.

#include <string>

#include "io/polygons.h"

namespace vasamesh {

/// Lines "v" and "f" (corners "7", "7/2", "7//3", "-1"), also with comments at their end, or
/// continued behind "\"; others are ignored.
/// \throws Error bad_input: not numbers, an index before the first vertex.
FannedMesh read_obj(const std::string& path);

}  // namespace vasamesh

#pragma once

/// \file
/// Triangles of a Wavefront OBJ file. VTK's reader gives each corner with its own texture or normal
/// a vertex of its own, which tears a closed surface open.

#include <string>

#include "vasamesh/types.h"

namespace vasamesh {

/// Lines "v" and "f" (fans of polygons; corners "7", "7/2", "7//3", "-1"); others are ignored.
/// \throws Error bad_input: not numbers, an index out of range.
TriangleMesh read_obj(const std::string& path);

}  // namespace vasamesh

#pragma once

/// \file
/// Triangles of an STL file (3D Systems, StereoLithography Interface Specification, 1989). VTK's
/// reader takes all that follows for triangles, whatever the number before them says, and text only
/// in the spelling that it writes itself.

#include <string>

#include "vasamesh/types.h"

namespace vasamesh {

/// Binary, or text in any case; a file whose length is that of a binary one is binary, whatever it
/// begins with. What follows the triangles of a binary file is no part of them, but where their
/// number is 0, all are. Each triangle has vertices of its own.
/// \throws Error bad_input: fewer triangles than the file says, not such a file, text that does not
///         end.
TriangleMesh read_stl(const std::string& path);

}  // namespace vasamesh

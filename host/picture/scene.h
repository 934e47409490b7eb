#pragma once

/// \file
/// One surface, rendered without a window.

#include <array>
#include <optional>
#include <string>

namespace vasamesh {

struct PictureOptions {
  std::string surface;                        ///< .vtp, .stl, .ply or .obj
  std::string output;                         ///< .png
  std::array<double, 3> view{0, -1, 0};       ///< from the surface to the eye, in its own axes
  std::optional<std::array<double, 4>> zoom;  ///< fill the picture with the ball (x, y, z, radius)
  bool edges = false;                         ///< draw the triangles' edges
  std::array<int, 2> size{1200, 900};         ///< pixels
};

/// Renders the surface and writes the picture. Needs an X display.
/// \throws Error bad_input (the surface), refused (the picture cannot be written).
void render_picture(const PictureOptions& options);

}  // namespace vasamesh

/// \file
/// vasamesh_picture: a picture of a surface file. Without an X display it starts an Xvfb
/// (Debian: xvfb, libgl1-mesa-dri).

#include <vtkObject.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <string>

#include "picture/display.h"
#include "picture/scene.h"
#include "vasamesh/errors.h"

namespace {

using vasamesh::Error;
using vasamesh::ErrorCode;

std::array<int, 2> parse_size(const std::string& text) {
  std::array<int, 2> size{};
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size[0], &size[1], &rest) != 2 || size[0] < 16 ||
      size[1] < 16 || size[0] > 8192 || size[1] > 8192)
    throw Error(ErrorCode::usage, "--size " + text + ": give WIDTHxHEIGHT, 16 to 8192 each");
  return size;
}

void run(const vasamesh::PictureOptions& options) {
  if (options.view == std::array<double, 3>{0, 0, 0})
    throw Error(ErrorCode::usage, "--view 0 0 0: no direction; give one, as 0 -1 0");
  if (options.zoom && !((*options.zoom)[3] > 0))
    throw Error(ErrorCode::usage, "--zoom-to: the radius must be above zero, in mm");
  const vasamesh::OwnDisplay display;
  vtkObject::GlobalWarningDisplayOff();
  vasamesh::render_picture(options);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A picture (PNG) of a surface (.vtp, .stl, .ply, .obj).");
  vasamesh::PictureOptions options;
  std::string size = "1200x900";
  std::array<double, 4> zoom{};
  app.add_option("surface", options.surface, "the surface file")->required();
  app.add_option("output", options.output, "the picture, .png")->required();
  app.add_option("--view", options.view, "direction from the surface to the eye")
      ->capture_default_str();
  const auto* zoom_option =
      app.add_option("--zoom-to", zoom, "fill the picture with the ball x y z radius, in mm");
  app.add_flag("--edges", options.edges, "draw the triangles' edges");
  app.add_option("--size", size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  try {
    app.parse(argc, argv);
    options.size = parse_size(size);
    if (zoom_option->count() > 0) options.zoom = zoom;
    run(options);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::usage);
  } catch (const Error& error) {
    std::fprintf(stderr, "vasamesh_picture: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vasamesh_picture: %s\n", error.what());
    return static_cast<int>(ErrorCode::internal);
  }
}

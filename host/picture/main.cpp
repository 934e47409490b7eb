/// \file
/// vasamesh_picture: a picture of a surface file. Without an X display it starts itself again
/// under xvfb-run (Debian: xvfb, xauth, libgl1-mesa-dri).

#include <unistd.h>
#include <vtkObject.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "picture/display.h"
#include "picture/scene.h"
#include "vasamesh/errors.h"

namespace {

using vasamesh::Error;
using vasamesh::ErrorCode;

/// Set in the environment of the process that xvfb-run starts.
constexpr const char* kStarted = "VASAMESH_PICTURE_IN_XVFB";

/// Replaces this process by the same command inside a virtual X display; returns only on failure.
void start_in_virtual_display(char** argv) {
  std::string xvfb = "xvfb-run", any = "-a", screen_option = "-s", screen = "-screen 0 640x480x24";
  std::vector<char*> command = {xvfb.data(), any.data(), screen_option.data(), screen.data()};
  for (char** arg = argv; *arg; ++arg) command.push_back(*arg);
  command.push_back(nullptr);
  execvp(command[0], command.data());
}

void need_display(char** argv) {
  if (vasamesh::has_display()) return;
  if (!std::getenv(kStarted)) {
    setenv(kStarted, "1", 1);
    start_in_virtual_display(argv);
  }
  throw Error(ErrorCode::no_device,
              "DISPLAY: no X display, and xvfb-run gave none; install xvfb and xauth");
}

std::array<int, 2> parse_size(const std::string& text) {
  std::array<int, 2> size{};
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size[0], &size[1], &rest) != 2 || size[0] < 16 ||
      size[1] < 16 || size[0] > 8192 || size[1] > 8192)
    throw Error(ErrorCode::usage, "--size " + text + ": give WIDTHxHEIGHT, 16 to 8192 each");
  return size;
}

void run(const vasamesh::PictureOptions& options, char** argv) {
  if (options.view == std::array<double, 3>{0, 0, 0})
    throw Error(ErrorCode::usage, "--view 0 0 0: no direction; give one, as 0 -1 0");
  if (options.zoom && !((*options.zoom)[3] > 0))
    throw Error(ErrorCode::usage, "--zoom-to: the radius must be above zero, in mm");
  need_display(argv);
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
    run(options, argv);
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

/// \file
/// `vasamesh phantom`: the project's own inputs, as volume files and exact surfaces.

#include "phantom/phantom.h"

#include <fmt/core.h>

#include <utility>

#include "cli/commands.h"
#include "cli/distinct_files.h"
#include "cli/interrupt.h"
#include "io/surface_io.h"
#include "io/volume_reader.h"

namespace vasamesh::cli {

void run_phantom(const PhantomRequest& request) {
  catch_interrupts(true);
  check_volume_path(request.output);
  if (!request.surface.empty()) check_output_path(request.surface);
  check_distinct({}, {{"--output", request.output}, {"--surface", request.surface}});
  PhantomOptions options = request.options;
  options.exact = !request.surface.empty();
  Phantom phantom = make_phantom(request.name, options);
  if (options.exact && !phantom.exact)
    throw Error(ErrorCode::usage, "--surface: phantom " + request.name +
                                      " has no exact surface; leave the option out");
  stop_if_interrupted();

  const Segmentation volume{phantom.geometry, std::move(phantom.voxels)};
  write_segmentation(request.output, volume, &interrupted());
  const auto& [x, y, z] = volume.geometry.size;
  fmt::print("{}: {} x {} x {} voxels\n", request.output, x, y, z);
  if (!phantom.exact) return;
  stop_if_interrupted();
  write_surface(request.surface, *phantom.exact, Space::lps, &interrupted());
  fmt::print("{}: {} triangles\n", request.surface, phantom.exact->triangle_count());
}

}  // namespace vasamesh::cli

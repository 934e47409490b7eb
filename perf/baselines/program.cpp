#include "program.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "vasamesh/errors.h"

namespace vasamesh::baselines {

namespace {

struct Box {
  std::array<std::int64_t, 3> low, high;
};

Box object_box(const Segmentation& segmentation) {
  const auto& size = segmentation.geometry.size;
  Box box{size, {-1, -1, -1}};
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size[2]; ++z)
    for (std::int64_t y = 0; y < size[1]; ++y)
      for (std::int64_t x = 0; x < size[0]; ++x, ++at) {
        if (segmentation.voxels[at] == 0) continue;
        const std::array<std::int64_t, 3> voxel = {x, y, z};
        for (int a = 0; a < 3; ++a) {
          box.low[a] = std::min(box.low[a], voxel[a]);
          box.high[a] = std::max(box.high[a], voxel[a]);
        }
      }
  if (box.high[0] < 0)
    throw Error(ErrorCode::bad_input, "nothing is in the foreground of the volume");
  return box;
}

}  // namespace

Segmentation cropped(const Segmentation& segmentation, int border) {
  const Box box = object_box(segmentation);
  const Geometry& whole = segmentation.geometry;
  Segmentation part;
  part.geometry = whole;
  for (int a = 0; a < 3; ++a) {
    part.geometry.size[a] = box.high[a] - box.low[a] + 1 + 2 * border;
    for (int b = 0; b < 3; ++b)
      part.geometry.origin[a] +=
          whole.direction[3 * a + b] * whole.spacing[b] * static_cast<double>(box.low[b] - border);
  }
  const auto& size = part.geometry.size;
  part.voxels.assign(static_cast<std::size_t>(size[0] * size[1] * size[2]), 0);
  for (std::int64_t z = box.low[2]; z <= box.high[2]; ++z)
    for (std::int64_t y = box.low[1]; y <= box.high[1]; ++y) {
      const auto row = segmentation.voxels.begin() + whole.size[0] * (y + whole.size[1] * z);
      const std::int64_t to =
          border + size[0] * (y - box.low[1] + border + size[1] * (z - box.low[2] + border));
      std::copy(row + box.low[0], row + box.high[0] + 1, part.voxels.begin() + to);
    }
  return part;
}

int run_program(CLI::App& app, int argc, char** argv, const Method& method) {
  std::string input, output;
  app.add_option("volume", input, "the segmentation: every voxel but 0 is object")->required();
  app.add_option("surface", output, "what to write, .ply")->required();
  try {
    app.parse(argc, argv);
    ReadOptions read;
    read.any_label = true;
    method(read_segmentation(input, read), output);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::usage);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), error.what());
    return static_cast<int>(ErrorCode::internal);
  }
}

}  // namespace vasamesh::baselines

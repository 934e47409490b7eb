/// \file
/// vasamesh_baseline_mpu VOLUME SURFACE.ply [--tolerance T] [--cube C]: multi-level partition of
/// unity implicits of the library's samples, and Bloomenthal's polygonizer.

#include "io/surface_io.h"
#include "mpu.h"
#include "polygonizer.h"
#include "program.h"

namespace vasamesh::baselines {
namespace {

void convert(const Segmentation& volume, const std::string& output, const MpuOptions& options,
             double cube) {
  const Mpu mpu(oriented_samples(volume), options);
  Polygonization grid{cube, {}};
  for (const Sample& sample : mpu.samples()) grid.seeds.push_back(sample.position);
  TriangleMesh mesh = polygonize([&](const Eigen::Vector3d& p) { return mpu.value(p); }, grid);
  place_in_lps(volume.geometry, mesh);
  write_surface(output, mesh, Space::lps);
}

}  // namespace
}  // namespace vasamesh::baselines

int main(int argc, char** argv) {
  using namespace vasamesh;
  CLI::App app("MPU implicits of a segmentation's boundary", "vasamesh_baseline_mpu");
  baselines::MpuOptions options;
  double cube = 1;
  app.add_option("--tolerance", options.tolerance, "largest distance of a sample, voxels")
      ->capture_default_str();
  app.add_option("--least-cell", options.least_cell,
                 "half edge below which no cell is split, voxels")
      ->capture_default_str();
  app.add_option("--cube", cube, "edge of the polygonizer's cubes, voxels")->capture_default_str();
  return baselines::run_program(app, argc, argv,
                                [&](const Segmentation& volume, const std::string& output) {
                                  baselines::convert(volume, output, options, cube);
                                });
}

/// \file
/// vasamesh_baseline_points VOLUME POINTS.ply: the library's oriented samples, mm, LPS, for
/// programs that reconstruct surfaces from points.

#include <fmt/core.h>

#include "io/atomic_file.h"
#include "program.h"
#include "samples.h"

namespace vasamesh::baselines {
namespace {

void write_points(const Segmentation& volume, const std::string& output) {
  const std::vector<Sample> samples = oriented_samples(volume);
  TriangleMesh places;
  for (const Sample& sample : samples)
    for (int a = 0; a < 3; ++a) places.vertices.push_back(static_cast<float>(sample.position[a]));
  place_in_lps(volume.geometry, places);
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n",
      samples.size());
  const auto& d = volume.geometry.direction;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const float* p = &places.vertices[3 * i];
    const Eigen::Vector3d& n = samples[i].normal;
    text += fmt::format("{} {} {} {:.6f} {:.6f} {:.6f}\n", p[0], p[1], p[2],
                        d[0] * n[0] + d[1] * n[1] + d[2] * n[2],
                        d[3] * n[0] + d[4] * n[1] + d[5] * n[2],
                        d[6] * n[0] + d[7] * n[1] + d[8] * n[2]);
  }
  write_file(output, text);
}

}  // namespace
}  // namespace vasamesh::baselines

int main(int argc, char** argv) {
  CLI::App app("Oriented samples of a segmentation", "vasamesh_baseline_points");
  return vasamesh::baselines::run_program(app, argc, argv, vasamesh::baselines::write_points);
}

/// \file
/// Embeds the installed library: a ball in memory in, its closed surface out.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"
#include "vasamesh/version.h"

namespace {

constexpr int kSide = 24;
constexpr double kRadius = 8.0;

std::vector<std::uint8_t> ball() {
  std::vector<std::uint8_t> voxels;
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const double dx = x - 11.5, dy = y - 11.5, dz = z - 11.5;
        voxels.push_back(dx * dx + dy * dy + dz * dz < kRadius * kRadius);
      }
  return voxels;
}

/// One sphere, of the ball's volume within 5 %.
bool is_ball(const vasamesh::Report& report) {
  const double wanted = 4.0 / 3.0 * 3.14159265 * kRadius * kRadius * kRadius;
  return report.check.passed && report.check.topology == vasamesh::Topology{1, 0, 0} &&
         std::abs(report.quality.volume - wanted) < 0.05 * wanted;
}

}  // namespace

int main() {
  const std::vector<std::uint8_t> voxels = ball();
  vasamesh::VolumeView volume;
  volume.data = voxels.data();
  volume.geometry.size = {kSide, kSide, kSide};
  try {
    vasamesh::Context context = vasamesh::make_context({});
    const vasamesh::Result result = vasamesh::convert(volume, {}, context);
    std::printf("vasamesh %s: %zu triangles\n", vasamesh::version(), result.mesh.triangle_count());
    return is_ball(result.report) ? 0 : 1;
  } catch (const vasamesh::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
}

#include "samples.h"

#include "stages/normals.h"
#include "stages/points.h"
#include "stages/surface.h"
#include "tbb/backend.h"

namespace vasamesh::baselines {

std::vector<Sample> oriented_samples(const Segmentation& segmentation) {
  const auto backend = make_tbb_backend(0, nullptr);
  const Scale scale = make_scale(segmentation.geometry);
  const BitVolume object = pack_volume(*backend, segmentation.view());
  PointCloud points = extract_points(*backend, object, scale);
  estimate_normals(*backend, object, scale, Parameters{}, points);
  const PointView view = points.view();
  std::vector<Sample> samples(view.count);
  for (std::size_t i = 0; i < view.count; ++i)
    for (int a = 0; a < 3; ++a) {
      samples[i].position[a] = double{view.position[a][i]} * scale[a];
      samples[i].normal[a] = view.normal[a][i];
    }
  return samples;
}

void place_in_lps(const Geometry& geometry, TriangleMesh& mesh) {
  const Scale scale = make_scale(geometry);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] /= scale[i % 3];
  place_in_space(*make_tbb_backend(0, nullptr), geometry, Space::lps, mesh);
}

}  // namespace vasamesh::baselines

#include "stages/normals.h"

namespace vasamesh {

namespace {

using Vectors = std::array<Buffer<float>, 3>;

Vectors make_vectors(Backend& backend, std::size_t count) {
  return {Buffer<float>(backend, count), Buffer<float>(backend, count),
          Buffer<float>(backend, count)};
}

std::array<View<float>, 3> views(Vectors& v) { return {v[0].view(), v[1].view(), v[2].view()}; }

}  // namespace

void estimate_normals(Backend& backend, const BitVolume& object, const Scale& scale,
                      const Parameters& parameters, PointCloud& points) {
  points.normal = make_vectors(backend, points.count);
  if (parameters.normals == NormalMode::gradient) {
    backend.normals_gradient(object.view(), points.view(), scale, kGradientSigma,
                             points.output().normal);
    return;
  }
  Vectors gradients = make_vectors(backend, points.count);
  backend.normals_gradient(object.view(), points.view(), scale, kSteeringSigma, views(gradients));
  backend.normals_covariance(
      points.view(), points.bricks.view(), points.voxel_start.view(), scale, parameters.neighbours,
      {gradients[0].view(), gradients[1].view(), gradients[2].view()}, points.output().normal);
}

}  // namespace vasamesh

/// Samples of the surface: their place on the zero set, normals and radii of curvature.

#include "stages/sizing.h"

#include "tbb/tbb_backend.h"

namespace vasamesh {

void TbbBackend::sizing_measure(const FieldView& field, float ample, View<Vec3> positions,
                                View<Vec3> normals, View<float> radii) {
  constexpr std::size_t kGrain = 64;  // samples a task takes
  for_each(positions.size, kGrain, [=](std::size_t i) {
    Vec3 p = positions[i];
    const FieldSample at = project_to_surface(field, kSampleReach, kSampleSteps, p);
    normals[i] = {};
    radii[i] = 0;
    if (!at.known) return;
    positions[i] = p;
    normals[i] = -normalised(at.gradient);
    radii[i] = radius_of_curvature(field, p, normals[i], ample);
  });
}

}  // namespace vasamesh

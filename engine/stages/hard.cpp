#include "stages/hard.h"

#include <algorithm>

namespace vasamesh {

namespace {

constexpr float kThin = 0.7f;    // of edge_min: a smaller radius of curvature is hard
constexpr float kRoom = 0.6f;    // of edge_min: no other sheet within this, along the normal
constexpr float kGrowth = 3.0f;  // edge lengths that regions are grown by
constexpr float kFar = 1e6f;
constexpr std::size_t kSampleGrain = 256, kTriangleGrain = 8192;

/// Whether the function keeps its sign on each side of the surface as far as `reach`.
bool has_room(const FieldView& field, const Vec3& p, const Vec3& normal, float reach) {
  for (const float part : {0.5f, 1.0f}) {
    const FieldSample outside = sample_field(field, p + (part * reach) * normal);
    const FieldSample inside = sample_field(field, p - (part * reach) * normal);
    if ((outside.known && outside.value >= 0) || (inside.known && inside.value <= 0)) return false;
  }
  return true;
}

bool is_hard(const FieldView& field, const SurfaceSamples& samples, const SizeRule& rule,
             std::size_t i) {
  return samples.radius[i] < kThin * rule.edge_min ||
         !has_room(field, samples.position[i], samples.normal[i], kRoom * rule.edge_min);
}

}  // namespace

std::vector<std::uint8_t> find_hard_regions(Backend& backend, const IndicatorField& field,
                                            const SizeField& sizes, const SizeRule& rule,
                                            const TriangleMesh& surface) {
  const FieldView view = field.view();
  const SurfaceSamples& samples = sizes.samples;
  Buffer<float> distance(backend, sizes.sizes.size());
  float* to_hard = distance.view().data();
  std::fill_n(to_hard, distance.size(), kFar);
  backend.run((samples.count() + kSampleGrain - 1) / kSampleGrain, [&](std::size_t task) {
    const std::size_t end = std::min((task + 1) * kSampleGrain, samples.count());
    for (std::size_t i = task * kSampleGrain; i < end; ++i)
      if (is_hard(view, samples, rule, i)) to_hard[samples.cell[i]] = 0;
  });
  grow_limited(backend, view, 1.0f, kGrowth * rule.edge_max, distance);

  const SizeView size_view = sizes.view(field);
  const SizeView distance_view = {view, distance.view(), kFar};
  const std::size_t count = surface.triangle_count();
  std::vector<std::uint8_t> hard(count);
  backend.run((count + kTriangleGrain - 1) / kTriangleGrain, [&](std::size_t task) {
    const std::size_t end = std::min((task + 1) * kTriangleGrain, count);
    for (std::size_t t = task * kTriangleGrain; t < end; ++t) {
      const float* p = &surface.vertices[std::size_t{3} * surface.triangles[3 * t]];
      const Vec3 at = {p[0], p[1], p[2]};
      hard[t] = size_at(distance_view, at) <= kGrowth * size_at(size_view, at);
    }
  });
  return hard;
}

}  // namespace vasamesh

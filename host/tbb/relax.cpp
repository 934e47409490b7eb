/// Smoothing and moves towards equal edges: a part a task.

#include "stages/fan_moves.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

void TbbBackend::relax_smooth(const FieldView& field, const SizeView& sizes,
                              const PlaceView& places, const FanView& fans, int passes,
                              View<SurfacePoint> points) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful};
  for_each(fans.parts(), 1, [&](std::size_t part) {
    for_each_fan(fans, points, part, passes,
                 [&](SurfacePoint& p, const Ring& ring) { smooth_vertex(goal, ring, p); });
  });
}

void TbbBackend::relax_equalise(const FieldView& field, const SizeView& sizes,
                                const PlaceView& places, const FanView& fans, int passes,
                                View<SurfacePoint> points) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful};
  for_each(fans.parts(), 1, [&](std::size_t part) {
    SurfacePoint moved;
    for_each_fan(fans, points, part, passes, [&](SurfacePoint& p, const Ring& ring) {
      if (find_more_equal(goal, ring, p, moved)) p = moved;
    });
  });
}

void TbbBackend::relax_gaps(const FieldView& field, const FanView& fans,
                            View<const SurfacePoint> points, View<float> gaps) {
  constexpr std::size_t kGrain = 128;  // fans a task takes
  for_each(gaps.size, kGrain, [=](std::size_t fan) {
    const std::uint32_t at = fans.ring_first[fan];
    const Ring ring = {points.data(), {fans.ring.data() + at, fans.ring_first[fan + 1] - at}};
    gaps[fan] = mean_gap(field, ring, points[fans.vertex[fan]]);
  });
}

}  // namespace vasamesh

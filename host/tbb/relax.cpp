/// Smoothing and moves towards equal edges: a part a task.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "stages/fan_moves.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

/// When vertices have moved, and fans were found to have no move left, counted in visits of a part.
/// A fan of which nothing has moved since would be found so again.
class Rest {
 public:
  Rest(std::size_t vertices, std::size_t fans) : moved_(vertices, 0), rested_(fans, 0) {}

  bool is_at_rest(std::size_t fan, std::uint32_t vertex, const Ring& ring) const {
    const std::uint32_t since = rested_[fan];
    return moved_[vertex] < since &&
           std::all_of(ring.vertices.begin(), ring.vertices.end(),
                       [&](std::uint32_t v) { return moved_[v] < since; });
  }
  void note(std::size_t fan, std::uint32_t vertex, bool moves, std::uint32_t visit) {
    (moves ? moved_[vertex] : rested_[fan]) = visit;
  }

 private:
  std::vector<std::uint32_t> moved_, rested_;  // 0: not yet
};

}  // namespace

void TbbBackend::relax_smooth(const FieldView& field, const SizeView& sizes,
                              const PlaceView& places, const FanView& fans, int passes,
                              View<SurfacePoint> points) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful};
  for_each(fans.parts(), 1, [&](std::size_t part) {
    for_each_fan(fans, part, passes, [&](std::uint32_t fan) {
      smooth_vertex(goal, ring_of(fans, points.data(), fan), points[fans.vertex[fan]]);
    });
  });
}

void TbbBackend::relax_equalise(const FieldView& field, const SizeView& sizes,
                                const PlaceView& places, const FanView& fans, int passes, bool onto,
                                View<SurfacePoint> points) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful};
  Rest rest(points.size, fans.vertex.size);
  for_each(fans.parts(), 1, [&](std::size_t part) {
    SurfacePoint moved;
    std::uint32_t visit = 0;
    for_each_fan(fans, part, passes, [&](std::uint32_t fan) {
      const std::uint32_t v = fans.vertex[fan];
      const Ring ring = ring_of(fans, points.data(), fan);
      ++visit;
      if (rest.is_at_rest(fan, v, ring)) return;
      const bool moves = find_more_equal(goal, ring, points[v], onto, moved);
      rest.note(fan, v, moves, visit);
      if (moves) points[v] = moved;
    });
  });
}

void TbbBackend::relax_gaps(const FieldView& field, const FanView& fans,
                            View<const SurfacePoint> points, View<float> gaps) {
  constexpr std::size_t kGrain = 128;  // fans a task takes
  for_each(gaps.size, kGrain, [=](std::size_t fan) {
    gaps[fan] = mean_gap(field, ring_of(fans, points.data(), fan), points[fans.vertex[fan]]);
  });
}

}  // namespace vasamesh

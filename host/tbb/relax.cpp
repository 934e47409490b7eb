/// Smoothing and moves towards equal edges: a part a task.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "stages/fan_moves.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::uint32_t kFansAsked = 64;  // between two checkpoints

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

/// The gaps of the edges in all fans, each found from one end: that with a fan, or else the lower.
class EdgeGaps {
 public:
  EdgeGaps(const FanView& fans, View<const SurfacePoint> points)
      : fans_(fans), points_(points), fan_of_(points.size, kNone), gap_(fans.ring.size) {
    for (std::uint32_t fan = 0; fan < fans.vertex.size; ++fan) fan_of_[fans.vertex[fan]] = fan;
  }

  /// Those that are found from the fan's vertex.
  void find(const FieldView& field, std::size_t fan) {
    const std::uint32_t v = fans_.vertex[fan];
    for (std::uint32_t e = fans_.ring_first[fan]; e + 1 < fans_.ring_first[fan + 1]; ++e)
      if (is_found_from(v, fans_.ring[e]))
        gap_[e] = edge_gap(field, points_[v], points_[fans_.ring[e]]);
  }

  /// To vertex i of the fan's ring. \pre all have been found.
  std::optional<float> at(std::size_t fan, std::size_t i) const {
    const std::uint32_t v = fans_.vertex[fan],
                        e = fans_.ring_first[fan] + static_cast<std::uint32_t>(i),
                        w = fans_.ring[e];
    if (is_found_from(v, w)) return gap_[e];
    const auto other = fans_.ring.data() + fans_.ring_first[fan_of_[w]];
    return gap_[std::find(other, fans_.ring.data() + fans_.ring.size, v) - fans_.ring.data()];
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  bool is_found_from(std::uint32_t v, std::uint32_t w) const {
    return v < w || fan_of_[w] == kNone;
  }

  const FanView& fans_;
  View<const SurfacePoint> points_;
  std::vector<std::uint32_t> fan_of_;      // of a point
  std::vector<std::optional<float>> gap_;  // of an entry of the rings
};

}  // namespace

void TbbBackend::relax_smooth(const FieldView& field, const SizeView& sizes,
                              const PlaceView& places, const FanView& fans, int passes,
                              View<SurfacePoint> points) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful};
  for_each(fans.parts(), 1, [&](std::size_t part) {
    for_each_fan(fans, part, passes, [&](std::uint32_t fan) {
      if (fan % kFansAsked == 0) checkpoint();
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
      if (fan % kFansAsked == 0) checkpoint();
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
  EdgeGaps edges(fans, points);
  for_each(gaps.size, kGrain, [&](std::size_t fan) { edges.find(field, fan); });
  for_each(gaps.size, kGrain, [&](std::size_t fan) {
    gaps[fan] = mean_gap(ring_of(fans, points.data(), fan), points[fans.vertex[fan]],
                         [&](std::size_t i) { return edges.at(fan, i); });
  });
}

}  // namespace vasamesh

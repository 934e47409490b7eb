/// Gaps: each by the dynamic programming of the engine, parts of about equal work at a time.

#include <algorithm>

#include "stages/triangulate_gap.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

void TbbBackend::stitch_triangulate(const GapRules& rules, StitchMode mode, const GapView& gaps,
                                    View<std::uint8_t> closed, View<std::uint16_t> triangles) {
  const auto corners = [&](std::size_t g) -> std::size_t {
    return gaps.first[g + 1] - gaps.first[g];
  };
  const std::vector<std::size_t> starts = parts_of_gaps(gaps.count(), corners);
  for_each(starts.size() - 1, 1, [&](std::size_t part) {
    GapTriangulator triangulator;
    for (std::size_t g = starts[part]; g < starts[part + 1]; ++g) {
      closed[g] = triangulator.run(gap_polygon(gaps, g), rules, mode);
      const auto found = triangulator.triangles();
      std::copy(found.begin(), found.end(), &triangles[3 * (gaps.first[g] - 2 * g)]);
    }
  });
}

}  // namespace vasamesh

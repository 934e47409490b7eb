/// Gaps: kernels/stitch.cl. Those of about a length are a launch, with groups as large as they
/// need.

#include <algorithm>

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

constexpr int kLeastItems = 16, kMostItems = 64;

/// Items of a group for a gap of n corners, where a group is more than an item.
int items_for(std::uint32_t n) {
  int items = kLeastItems;
  while (items < kMostItems && static_cast<std::uint32_t>(items) < n) items *= 2;
  return items;
}

}  // namespace

void OpenClBackend::stitch_triangulate(const GapRules& rules, StitchMode mode, const GapView& gaps,
                                       View<std::uint8_t> closed, View<std::uint16_t> triangles) {
  const std::size_t entries = gaps.chords.size;
  const std::size_t paper_entries = mode == StitchMode::paper ? entries : 0;
  Buffer<float> least(*this, entries), sum(*this, entries), turn(*this, paper_entries);
  Buffer<Vec3> top(*this, paper_entries);
  Buffer<std::uint16_t> via(*this, entries);
  const cl_float4 limits{{rules.least_cosine, rules.middle_cosine, rules.reach, 0}};
  const auto launch_some = [&](std::size_t first, std::size_t count, int items) {
    const auto gap_first = static_cast<cl_uint>(first);
    if (mode == StitchMode::paper)
      launch("stitch_paper", count, items, gap_first, limits, rules.field, gaps.first,
             gaps.chord_first, gaps.points, gaps.normals, gaps.chords, gaps.across, least.view(),
             sum.view(), turn.view(), top.view(), via.view(), closed, triangles);
    else
      launch("stitch_exact", count, items, gap_first, limits, rules.field, gaps.first,
             gaps.chord_first, gaps.points, gaps.normals, gaps.chords, least.view(), sum.view(),
             via.view(), closed, triangles);
  };
  const auto corners = on_host(gaps.first);
  const auto items_of = [&](std::size_t g) {
    return shape_.brick_items == 1 ? 1 : items_for(corners[g + 1] - corners[g]);
  };
  for (std::size_t first = 0, g = 0; g < gaps.count(); first = g) {
    const int items = items_of(first);
    while (g < gaps.count() && items_of(g) == items) ++g;
    launch_some(first, g - first, items);
  }
}

}  // namespace vasamesh

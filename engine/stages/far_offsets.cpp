#include "stages/far_offsets.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "types/lattice.h"

namespace vasamesh {

namespace {

constexpr int kBesideReach = 3;  // nodes along each axis
constexpr int kSearchReach = 6;

float length_of(const Scale& scale, int x, int y, int z) {
  const float dx = 0.5f * scale[0] * static_cast<float>(x),
              dy = 0.5f * scale[1] * static_cast<float>(y),
              dz = 0.5f * scale[2] * static_cast<float>(z);
  return std::sqrt((dx * dx + dy * dy) + dz * dz);
}

/// Offsets of at most `most`, shortest first; ties in raster order.
std::vector<FarOffset> offsets_within(const Scale& scale, float most, int reach) {
  std::vector<FarOffset> offsets;
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const float length = length_of(scale, x, y, z);
        const int low = std::min({x, y, z}), high = std::max({x, y, z});
        const bool edge = (low >= 0 && high == 1) || (high <= 0 && low == -1);
        if (length <= most) offsets.push_back({x, y, z, length, edge});
      }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const FarOffset& a, const FarOffset& b) { return a.length < b.length; });
  return offsets;
}

}  // namespace

FarOffsets make_far_offsets(const Scale& scale, float limit) {
  FarOffsets offsets;
  float longest = 0;
  for (std::size_t d = 0; d < 7; ++d) {
    offsets.edge_length[d] = length_of(scale, kLink[d].x, kLink[d].y, kLink[d].z);
    longest = std::max(longest, offsets.edge_length[d]);
  }
  offsets.search = offsets_within(scale, limit + longest, kSearchReach);
  offsets.beside = offsets_within(scale, std::max(limit, longest), kBesideReach);
  std::erase_if(offsets.beside, [&](const FarOffset& o) { return !o.edge && o.length > limit; });
  return offsets;
}

std::array<int, 3> far_reach(const FarOffsets& offsets) {
  constexpr int kOctant = 4;  // nodes
  std::array<int, 3> nodes{1, 1, 1};
  for (const auto* list : {&offsets.beside, &offsets.search})
    for (const FarOffset& o : *list) {
      const std::array<int, 3> step = {o.x, o.y, o.z};
      // Edges lead one node on; faces lie one node from their cube's corner.
      for (std::size_t a = 0; a < 3; ++a) nodes[a] = std::max(nodes[a], std::abs(step[a]) + 1);
    }
  for (int& reach : nodes) reach = (reach + kOctant - 1) / kOctant;
  return nodes;
}

}  // namespace vasamesh

#include "stages/link.h"

#include <algorithm>

namespace vasamesh {

namespace {

/// Whether two neighbours in a node's link are joined.
constexpr bool joined(const NodeOffset& a, const NodeOffset& b) {
  const int x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
  const int least = std::min({x, y, z}), most = std::max({x, y, z});
  return (least >= 0 && most == 1) || (most <= 0 && least == -1);
}

constexpr std::array<std::uint32_t, 14> make_joins() {
  std::array<std::uint32_t, 14> joins{};
  for (std::size_t i = 0; i < kLink.size(); ++i)
    for (std::size_t j = 0; j < kLink.size(); ++j)
      if (i != j && joined(kLink[i], kLink[j])) joins[i] |= 1u << j;
  return joins;
}

constexpr std::array<std::uint32_t, 14> kJoins = make_joins();

}  // namespace

std::uint32_t link_component(std::uint32_t members) {
  std::uint32_t reached = members & (~members + 1), before = 0;
  while (reached != before) {
    before = reached;
    for (std::size_t i = 0; i < kJoins.size(); ++i)
      if (before >> i & 1) reached |= kJoins[i] & members;
  }
  return reached;
}

int link_components(std::uint32_t members) {
  int count = 0;
  for (; members; members &= ~link_component(members)) ++count;
  return count;
}

std::array<std::uint8_t, kLinkCount> make_simple_table() {
  std::array<std::uint8_t, kLinkCount> simple{};
  for (std::uint32_t labels = 0; labels < kLinkCount; ++labels)
    simple[labels] =
        link_components(labels) == 1 && link_components(~labels & (kLinkCount - 1)) == 1;
  return simple;
}

}  // namespace vasamesh

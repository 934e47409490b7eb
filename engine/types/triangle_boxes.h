#pragma once

/// \file
/// A triangle surface and the tree of boxes over it in flat arrays, as passes take them.

#include <cstddef>
#include <cstdint>

#include "types/buffer.h"

namespace vasamesh {

/// Eight boxes; empty ones have low above high.
struct BoxNode {
  alignas(32) float low[3][8];
  alignas(32) float high[3][8];
};

struct MeshView {
  View<const float> vertices;  ///< three a vertex
  View<const std::uint32_t> triangles;
};

/// A TriangleTree (stages/triangle_tree.h): its levels one after the other, from the leaves to the
/// root.
struct TreeView {
  View<const std::uint32_t> order;
  View<const BoxNode> nodes;
  View<const std::uint32_t> level_first;  ///< levels + 1 entries: the level's first node

  int levels() const { return static_cast<int>(level_first.size) - 1; }
  std::size_t leaves() const { return level_first.size > 1 ? level_first[1] : 0; }
};

}  // namespace vasamesh

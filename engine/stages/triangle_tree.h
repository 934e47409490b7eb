#pragma once

/// \file
/// A tree of boxes over triangles: eight boxes a node, the triangles in Morton order of their
/// centres, no pointers. Node k of a level holds the boxes of nodes 8 k .. 8 k + 7 of the level
/// below; the nodes of level 0 hold the boxes of eight triangles.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "types/box.h"
#include "types/triangle_boxes.h"
#include "vasamesh/types.h"

namespace vasamesh {

struct TriangleTree {
  std::vector<std::uint32_t> order;          ///< triangles, in the tree's order
  std::vector<std::vector<BoxNode>> levels;  ///< from the triangles' boxes to the one root

  bool empty() const { return order.empty(); }
};

/// The tree of all triangles for which `keep` is set (one a triangle; all when empty). Their
/// vertices must be finite.
TriangleTree build_triangle_tree(Backend& backend, const TriangleMesh& mesh,
                                 const std::vector<std::uint8_t>& keep = {});

/// The same with the triangles in the order that they have: for surfaces in which those that follow
/// one another lie near each other, as cut from a lattice brick by brick.
TriangleTree build_tree_in_order(Backend& backend, const TriangleMesh& mesh);

/// Bit i is set when box i of the node meets `box`, which is finite.
inline unsigned meeting(const BoxNode& node, const Box& box) {
  float gap[8];  // the largest along the axes; in this form compilers do all eight at once
  for (int i = 0; i < 8; ++i) {
    const float x = std::max(node.low[0][i] - box.high.x, box.low.x - node.high[0][i]);
    const float y = std::max(node.low[1][i] - box.high.y, box.low.y - node.high[1][i]);
    const float z = std::max(node.low[2][i] - box.high.z, box.low.z - node.high[2][i]);
    gap[i] = std::max(std::max(x, y), z);
  }
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) mask |= gap[i] <= 0 ? 1u << i : 0u;
  return mask;
}

/// The box round all eight.
Box box_of(const BoxNode& node);

/// Box i of a node.
inline Box box_of(const BoxNode& node, int i) {
  return {{node.low[0][i], node.low[1][i], node.low[2][i]},
          {node.high[0][i], node.high[1][i], node.high[2][i]}};
}

/// Calls visit(leaf) for the leaf nodes from `first` on whose boxes meet `box`.
/// \param node_at  (level, node) -> BoxNode.
template <class NodeAt, class Visit>
void for_each_leaf(int levels, const NodeAt& node_at, const Box& box, std::size_t first,
                   const Visit& visit) {
  struct Entry {
    int level;
    std::size_t node;
  };
  Entry stack[128];
  int size = 0;
  stack[size++] = {levels - 1, 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.level == 0) {
      visit(entry.node);
      continue;
    }
    for (unsigned hits = meeting(node_at(entry.level, entry.node), box); hits; hits &= hits - 1) {
      const std::size_t child = 8 * entry.node + std::countr_zero(hits);
      const std::size_t last = ((child + 1) << 3 * (entry.level - 1)) - 1;
      if (last >= first) stack[size++] = {entry.level - 1, child};
    }
  }
}

template <class Visit>
void for_each_leaf(const TriangleTree& tree, const Box& box, std::size_t first,
                   const Visit& visit) {
  const auto node_at = [&](int level, std::size_t node) -> const BoxNode& {
    return tree.levels[static_cast<std::size_t>(level)][node];
  };
  for_each_leaf(static_cast<int>(tree.levels.size()), node_at, box, first, visit);
}

}  // namespace vasamesh

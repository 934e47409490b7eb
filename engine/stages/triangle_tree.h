#pragma once

/// \file
/// A tree of boxes over triangles: eight boxes a node, the triangles in Morton order of their
/// centres, no pointers. Node k of a level holds the boxes of nodes 8 k .. 8 k + 7 of the level
/// below; the nodes of level 0 hold the boxes of eight triangles.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Eight boxes; empty ones have low above high.
struct BoxNode {
  alignas(32) float low[3][8];
  alignas(32) float high[3][8];
};

struct Box {
  float low[3], high[3];
};

struct TriangleTree {
  std::vector<std::uint32_t> order;          ///< triangles, in the tree's order
  std::vector<std::vector<BoxNode>> levels;  ///< from the triangles' boxes to the one root

  bool empty() const { return order.empty(); }
};

/// The tree of all triangles for which `keep` is set (one a triangle; all when empty). Their
/// vertices must be finite.
TriangleTree build_triangle_tree(Backend& backend, const TriangleMesh& mesh,
                                 const std::vector<std::uint8_t>& keep = {});

/// Bit i is set when box i of the node meets `box`.
inline unsigned meeting(const BoxNode& node, const Box& box) {
  std::uint32_t hit[8];
  for (int i = 0; i < 8; ++i)
    hit[i] = (node.low[0][i] <= box.high[0]) & (node.high[0][i] >= box.low[0]) &
             (node.low[1][i] <= box.high[1]) & (node.high[1][i] >= box.low[1]) &
             (node.low[2][i] <= box.high[2]) & (node.high[2][i] >= box.low[2]);
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) mask |= hit[i] << i;
  return mask;
}

/// The box round all eight.
Box box_of(const BoxNode& node);

/// Box i of a node.
inline Box box_of(const BoxNode& node, int i) {
  return {{node.low[0][i], node.low[1][i], node.low[2][i]},
          {node.high[0][i], node.high[1][i], node.high[2][i]}};
}

}  // namespace vasamesh

#pragma once

/// \file
/// Pairs of triangles that may intersect: their boxes meet, and no plane tells them apart for
/// certain in float32 (separating_planes.h). Exact predicates decide on what is left (intersect.h).

#include <array>
#include <cstdint>
#include <vector>

#include "types/triangle_boxes.h"

namespace vasamesh {

/// Outside of these extents, underflow or overflow would add to the errors: nothing is certain.
inline constexpr float kLeastExtent = 1e-6f, kMostExtent = 1e6f;

/// The pairs of a leaf's triangles with those of itself and of later leaves.
class PairSearch {
 public:
  using Pair = std::array<std::uint32_t, 2>;

  /// \pre the views are in the host's memory.
  PairSearch(const MeshView& mesh, const TreeView& tree) : mesh_(mesh), tree_(tree) {}

  /// Those that may intersect, by the tree's order of leaves, then of the first triangle, then of
  /// the second. Good until the next call.
  const std::vector<Pair>& search(std::size_t leaf);

 private:
  void collect(std::size_t leaf, std::size_t other);

  const MeshView mesh_;
  const TreeView tree_;
  std::vector<Pair> boxes_meet_, found_;
  std::size_t size_ = 0;  ///< of boxes_meet_
};

}  // namespace vasamesh

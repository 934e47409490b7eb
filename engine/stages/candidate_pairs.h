#pragma once

/// \file
/// Pairs of triangles that may intersect: their boxes meet, and no plane tells them apart for
/// certain in float32. Exact predicates decide on what is left (intersect.h).
///
/// Gottschalk, Lin, Manocha: OBBTree, 1996 (separating axes); Shewchuk: Adaptive precision
/// floating-point arithmetic and fast robust geometric predicates, 1997 (the bounds of errors).

#include <array>
#include <cstdint>
#include <vector>

#include "types/triangle_boxes.h"
#include "types/vec3.h"

namespace vasamesh {

// With u = 2^-24 and all components of the vectors at most m in size, where a vector carries one
// rounding of a difference:
//   |error of dot(k, p)| <= 5 u |k|_1 m for any k;
//   |error of dot(cross(a, b), c)| <= 8 u * 6 m^3;
//   |error of dot(cross(a, b), cross(c, d))| <= 12 u * 12 m^4.
inline constexpr float kDotError = 8 * 0x1p-24f, kDeterminantError = 64 * 0x1p-24f,
                       kCrossDotError = 192 * 0x1p-24f;
/// Outside of these m, underflow or overflow would add to the errors: nothing is certain.
inline constexpr float kLeastExtent = 1e-6f, kMostExtent = 1e6f;

/// The corners of two triangles, those that they share first, relative to the first of `a`.
struct CornerPair {
  std::array<Vec3, 3> a, b;
  int common = 0;    ///< how many they share
  float extent = 0;  ///< the largest component
};

CornerPair corner_pair(const MeshView& mesh, std::uint32_t first, std::uint32_t second);

/// Whether the triangles, neither degenerate, certainly meet in nothing but what they share.
bool is_certainly_apart(const CornerPair& pair);

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

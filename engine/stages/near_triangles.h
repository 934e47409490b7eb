#pragma once

/// \file
/// The triangles of a surface that are near some points, side by side, so that a point is compared
/// with eight of them at a time.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/triangle_tree.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

class NearTriangles {
 public:
  /// Bit i is that of the i-th triangle.
  using Set = std::uint64_t;

  /// \pre the tree is that of the mesh's triangles.
  NearTriangles(const TriangleMesh& mesh, const TriangleTree& tree, float limit)
      : mesh_(mesh), tree_(tree), limit_(limit) {}

  /// Takes up those that may be within the limit of what lies between the points; of more than 64
  /// some that are spread over the others.
  void take_up(std::span<const Vec3> points);

  /// Those of them that are within the limit of a point for certain; it may lack some that are so
  /// by less than a ten thousandth.
  Set within(const Vec3& p) const { return within(p, limit_); }

  /// Whether all of a ball is within the limit of one triangle for certain. Takes up what is near
  /// its middle, if what was taken up before will not do.
  bool hold_ball(const Vec3& middle, float radius);

 private:
  static constexpr std::size_t kMost = 64;

  void take_up(const Box& box, const Vec3& origin);
  void add(std::uint32_t triangle);
  Set within(const Vec3& p, float reach) const;

  const TriangleMesh& mesh_;
  const TriangleTree& tree_;
  float limit_;
  Vec3 origin_;
  float corner_[9][kMost] = {};  ///< relative to it: x, y and z of the first corners, and so on
  std::size_t size_ = 0;
  std::vector<std::uint32_t> found_;
};

}  // namespace vasamesh

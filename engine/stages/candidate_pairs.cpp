#include "stages/candidate_pairs.h"

#include <algorithm>
#include <utility>

#include "stages/separating_planes.h"
#include "stages/triangle_tree.h"
#include "types/vec3.h"

namespace vasamesh {

namespace {

CornerPair<Vec3> corner_pair(const MeshView& mesh, std::uint32_t first, std::uint32_t second) {
  std::array<std::uint32_t, 3> p, q;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = mesh.triangles[3 * std::size_t{first} + i];
    q[i] = mesh.triangles[3 * std::size_t{second} + i];
  }
  CornerPair<Vec3> pair;
  auto& common = pair.common;
  for (int i = common; i < 3; ++i)
    for (int j = common; j < 3; ++j) {
      if (p[i] != q[j]) continue;
      std::swap(p[i], p[common]);
      std::swap(q[j], q[common++]);
      break;
    }
  const auto at = [&](std::uint32_t v) {
    const float* x = &mesh.vertices[3 * std::size_t{v}];
    return Vec3{x[0], x[1], x[2]};
  };
  const Vec3 origin = at(p[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    pair.a[i] = at(p[i]) - origin;
    pair.b[i] = at(q[i]) - origin;
    pair.extent =
        std::max({pair.extent, largest_component(pair.a[i]), largest_component(pair.b[i])});
  }
  return pair;
}

bool is_in_range(float extent) { return extent >= kLeastExtent && extent <= kMostExtent; }

}  // namespace

const std::vector<PairSearch::Pair>& PairSearch::search(std::size_t leaf) {
  size_ = 0;
  found_.clear();
  const auto node_at = [&](int level, std::size_t node) -> const BoxNode& {
    return tree_.nodes[tree_.level_first[static_cast<std::size_t>(level)] + node];
  };
  for_each_leaf(tree_.levels(), node_at, box_of(tree_.nodes[leaf]), leaf,
                [&](std::size_t other) { collect(leaf, other); });
  for (std::size_t i = 0; i < size_; ++i) {
    const CornerPair<Vec3> pair = corner_pair(mesh_, boxes_meet_[i][0], boxes_meet_[i][1]);
    if (!is_in_range(pair.extent) || !are_certainly_apart(pair)) found_.push_back(boxes_meet_[i]);
  }
  return found_;
}

/// Appends the pairs whose boxes meet. All eight are written and those that count are kept: a
/// branch on each would be mispredicted more often than not.
void PairSearch::collect(std::size_t leaf, std::size_t other) {
  const BoxNode &node = tree_.nodes[leaf], &others = tree_.nodes[other];
  if (boxes_meet_.size() < size_ + 72) boxes_meet_.resize(2 * size_ + 72);
  const std::size_t count = std::min<std::size_t>(8, tree_.order.size - 8 * leaf);
  for (std::size_t i = 0; i < count; ++i) {
    unsigned hits = meeting(others, box_of(node, static_cast<int>(i)));
    if (other == leaf) hits &= ~((2u << i) - 1);
    for (std::size_t j = 0; j < 8; ++j) {
      boxes_meet_[size_] = {tree_.order[8 * leaf + i],
                            tree_.order[std::min(8 * other + j, tree_.order.size - 1)]};
      size_ += hits >> j & 1;
    }
  }
}

}  // namespace vasamesh

#include "stages/candidate_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stages/triangle_tree.h"

namespace vasamesh {

namespace {

using Corners = std::array<Vec3, 3>;

float largest(const Vec3& a) { return std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)}); }

float dot_error(const Vec3& axis, float extent) {
  return kDotError * ((std::fabs(axis.x) + std::fabs(axis.y)) + std::fabs(axis.z)) * extent;
}

/// Whether planes across `axis` lie between two triangles.
bool separates(const Vec3& axis, const CornerPair& pair) {
  const float a0 = dot(axis, pair.a[0]), a1 = dot(axis, pair.a[1]), a2 = dot(axis, pair.a[2]);
  const float b0 = dot(axis, pair.b[0]), b1 = dot(axis, pair.b[1]), b2 = dot(axis, pair.b[2]);
  const float error = 2 * dot_error(axis, pair.extent);
  return std::min({a0, a1, a2}) > std::max({b0, b1, b2}) + error ||
         std::min({b0, b1, b2}) > std::max({a0, a1, a2}) + error;
}

Corners edges_of(const Corners& corner) {
  return {corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
}

/// Two triangles without a common vertex: across the normals, across the edges in their planes,
/// across an edge of each.
bool are_disjoint(const CornerPair& pair) {
  const Corners e = edges_of(pair.a), f = edges_of(pair.b);
  const Vec3 n = cross(e[0], e[1]), o = cross(f[0], f[1]);
  if (separates(n, pair) || separates(o, pair)) return true;
  for (const Vec3& edge : e)
    if (separates(cross(n, edge), pair)) return true;
  for (const Vec3& edge : f)
    if (separates(cross(o, edge), pair)) return true;
  for (const Vec3& edge : e)
    for (const Vec3& other : f)
      if (separates(cross(edge, other), pair)) return true;
  return false;
}

/// Whether x and y are of one sign, each beyond `error`.
bool same_side(float x, float y, float error) {
  return (x > error && y > error) || (x < -error && y < -error);
}

/// Whether the plane through the common vertex across `axis` lies between the triangles.
bool divides(const Vec3& axis, const CornerPair& pair) {
  const float error = dot_error(axis, pair.extent);
  return dot(axis, pair.a[1]) > error && dot(axis, pair.a[2]) > error &&
         dot(axis, pair.b[1]) < -error && dot(axis, pair.b[2]) < -error;
}

Vec3 unit(const Vec3& a) { return (1.0f / norm(a)) * a; }

/// Two triangles with one common vertex.
bool meet_in_vertex(const CornerPair& pair) {
  const Vec3 &a = pair.a[1], &b = pair.a[2], &c = pair.b[1], &d = pair.b[2];
  if (divides((a + b) - (c + d), pair)) return true;
  const float m = pair.extent, error = kDeterminantError * ((m * m) * m);
  const Vec3 n = cross(a, b), o = cross(c, d);
  return same_side(dot(n, c), dot(n, d), error) || same_side(dot(o, a), dot(o, b), error) ||
         divides((unit(a) + unit(b)) - (unit(c) + unit(d)), pair);
}

/// Two triangles with a common edge: not folded onto each other.
bool are_unfolded(const CornerPair& pair) {
  const Vec3 &edge = pair.a[1], &a = pair.a[2], &b = pair.b[2];
  const float m = pair.extent;
  const Vec3 n = cross(edge, a);
  return dot(n, cross(edge, b)) < -kCrossDotError * ((m * m) * (m * m)) ||
         std::fabs(dot(n, b)) > kDeterminantError * ((m * m) * m);
}

}  // namespace

CornerPair corner_pair(const MeshView& mesh, std::uint32_t first, std::uint32_t second) {
  std::array<std::uint32_t, 3> p, q;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = mesh.triangles[3 * std::size_t{first} + i];
    q[i] = mesh.triangles[3 * std::size_t{second} + i];
  }
  CornerPair pair;
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
    pair.extent = std::max({pair.extent, largest(pair.a[i]), largest(pair.b[i])});
  }
  return pair;
}

bool is_certainly_apart(const CornerPair& pair) {
  if (!(pair.extent >= kLeastExtent && pair.extent <= kMostExtent)) return false;
  switch (pair.common) {
    case 0:
      return are_disjoint(pair);
    case 1:
      return meet_in_vertex(pair);
    case 2:
      return are_unfolded(pair);
    default:
      return false;
  }
}

const std::vector<PairSearch::Pair>& PairSearch::search(std::size_t leaf) {
  size_ = 0;
  found_.clear();
  const auto node_at = [&](int level, std::size_t node) -> const BoxNode& {
    return tree_.nodes[tree_.level_first[static_cast<std::size_t>(level)] + node];
  };
  for_each_leaf(tree_.levels(), node_at, box_of(tree_.nodes[leaf]), leaf,
                [&](std::size_t other) { collect(leaf, other); });
  for (std::size_t i = 0; i < size_; ++i)
    if (!is_certainly_apart(corner_pair(mesh_, boxes_meet_[i][0], boxes_meet_[i][1])))
      found_.push_back(boxes_meet_[i]);
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

#include "stages/intersect.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "backend/ranges.h"
#include "stages/predicates.h"
#include "stages/separating_planes.h"
#include "types/mesh_vertex.h"
#include "types/vec3d.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 256;  // pairs a task takes

using Corners = const float* [3];

/// p - origin, to one rounding a component.
Vec3d relative(const float* p, const float* origin) {
  return {double{p[0]} - origin[0], double{p[1]} - origin[1], double{p[2]} - origin[2]};
}

/// \param common  how many corners they share, the first ones of both.
CornerPair<Vec3d> corner_pair(const Corners& p, const Corners& q, int common) {
  CornerPair<Vec3d> pair;
  pair.common = common;
  for (int i = 1; i < 3; ++i) pair.a[i] = relative(p[i], p[0]);
  for (int i = 0; i < 3; ++i) pair.b[i] = i < common ? pair.a[i] : relative(q[i], p[0]);
  for (int i = 0; i < 3; ++i)
    pair.extent =
        std::max({pair.extent, largest_component(pair.a[i]), largest_component(pair.b[i])});
  return pair;
}

/// An axis along which the triangle projects to one that is not degenerate.
int projection_axis(const Corners& t) {
  for (int axis = 0; axis < 2; ++axis)
    if (orient2d(t[0], t[1], t[2], axis) != 0) return axis;
  return 2;
}

bool between(const float* p, const float* q, const float* x, int axis) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  return std::min(p[i], q[i]) <= x[i] && x[i] <= std::max(p[i], q[i]) &&
         std::min(p[j], q[j]) <= x[j] && x[j] <= std::max(p[j], q[j]);
}

/// Whether two closed segments of one plane meet, seen along `axis`.
bool segments_meet(const float* p, const float* q, const float* r, const float* s, int axis) {
  const int r_side = orient2d(p, q, r, axis), s_side = orient2d(p, q, s, axis);
  const int p_side = orient2d(r, s, p, axis), q_side = orient2d(r, s, q, axis);
  if (r_side * s_side < 0 && p_side * q_side < 0) return true;
  return (r_side == 0 && between(p, q, r, axis)) || (s_side == 0 && between(p, q, s, axis)) ||
         (p_side == 0 && between(r, s, p, axis)) || (q_side == 0 && between(r, s, q, axis));
}

bool inside_in_plane(const float* p, const Corners& t, int axis) {
  const int a = orient2d(t[0], t[1], p, axis), b = orient2d(t[1], t[2], p, axis),
            c = orient2d(t[2], t[0], p, axis);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

/// Whether the closed segment (p, q) meets the closed triangle, not degenerate.
bool segment_meets_triangle(const float* p, const float* q, const Corners& t) {
  const int p_side = orient3d(t[0], t[1], t[2], p), q_side = orient3d(t[0], t[1], t[2], q);
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) {
    const int axis = projection_axis(t);
    if (inside_in_plane(p, t, axis) || inside_in_plane(q, t, axis)) return true;
    for (int i = 0; i < 3; ++i)
      if (segments_meet(p, q, t[i], t[(i + 1) % 3], axis)) return true;
    return false;
  }
  const int a = orient3d(p, q, t[0], t[1]), b = orient3d(p, q, t[1], t[2]),
            c = orient3d(p, q, t[2], t[0]);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

/// Two triangles without a common vertex.
bool disjoint_meet(const Corners& a, const Corners& b) {
  if (are_certainly_apart(corner_pair(a, b, 0))) return false;
  for (int i = 0; i < 3; ++i)
    if (segment_meets_triangle(a[i], a[(i + 1) % 3], b) ||
        segment_meets_triangle(b[i], b[(i + 1) % 3], a))
      return true;
  return false;
}

/// Two triangles with the common vertex 0. What else they share reaches the opposite edge of one.
bool meet_beyond_vertex(const Corners& a, const Corners& b) {
  if (are_certainly_apart(corner_pair(a, b, 1))) return false;
  return segment_meets_triangle(a[1], a[2], b) || segment_meets_triangle(b[1], b[2], a);
}

/// Two triangles with the common edge 0, 1: only when they lie on each other.
bool meet_beyond_edge(const Corners& a, const Corners& b) {
  if (are_certainly_apart(corner_pair(a, b, 2))) return false;
  const float* other = b[2];
  if (orient3d(a[0], a[1], a[2], other) != 0) return false;
  const int axis = projection_axis(a);
  return orient2d(a[0], a[1], other, axis) == orient2d(a[0], a[1], a[2], axis);
}

/// How the corners of two triangles pair up: `a` and `b` list the corners of each, common ones
/// first and in the same order.
struct Match {
  std::int8_t common = 0;
  std::int8_t a[3]{}, b[3]{};
};

/// \param equal  bit 3 i + j is set when corner i of the one is corner j of the other.
constexpr Match make_match(unsigned equal) {
  Match match;
  unsigned left_a = 7, left_b = 7;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (!(equal >> (3 * i + j) & 1) || !(left_a >> i & 1) || !(left_b >> j & 1)) continue;
      left_a &= ~(1u << i);
      left_b &= ~(1u << j);
      match.a[match.common] = static_cast<std::int8_t>(i);
      match.b[match.common++] = static_cast<std::int8_t>(j);
    }
  int next_a = match.common, next_b = match.common;
  for (std::int8_t i = 0; i < 3; ++i) {
    if (left_a >> i & 1) match.a[next_a++] = i;
    if (left_b >> i & 1) match.b[next_b++] = i;
  }
  return match;
}

constexpr std::array<Match, 512> make_matches() {
  std::array<Match, 512> matches;
  for (unsigned equal = 0; equal < 512; ++equal) matches[equal] = make_match(equal);
  return matches;
}

/// Without a branch: which corners are common is as good as random to a processor.
const Match& match_corners(const std::uint32_t* p, const std::uint32_t* q) {
  static constexpr std::array<Match, 512> kMatches = make_matches();
  unsigned equal = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) equal |= static_cast<unsigned>(p[i] == q[j]) << (3 * i + j);
  return kMatches[equal];
}

bool before(const TrianglePair& a, const TrianglePair& b) {
  return a.first != b.first ? a.first < b.first : a.second < b.second;
}

/// The lowest pairs, in order.
void keep_lowest(std::vector<TrianglePair>& pairs) {
  std::sort(pairs.begin(), pairs.end(), before);
  if (pairs.size() > Intersections::kMostListed) pairs.resize(Intersections::kMostListed);
}

/// The tree's levels one after the other in a backend's memory.
class FlatTree {
 public:
  FlatTree(Backend& backend, const TriangleTree& tree) : order_(tree.order) {
    std::vector<std::uint32_t> first{0};
    for (const std::vector<BoxNode>& level : tree.levels)
      first.push_back(first.back() + static_cast<std::uint32_t>(level.size()));
    level_first_ = Buffer<std::uint32_t>(backend, first.size());
    backend.upload<std::uint32_t>(level_first_.view(), first);
    nodes_ = Buffer<BoxNode>(backend, first.back());
    for (std::size_t i = 0; i < tree.levels.size(); ++i)
      backend.upload<BoxNode>(nodes_.view().subview(first[i], tree.levels[i].size()),
                              tree.levels[i]);
  }
  TreeView view() const { return {view_of(order_), nodes_.view(), level_first_.view()}; }

 private:
  const std::vector<std::uint32_t>& order_;
  Buffer<BoxNode> nodes_;
  Buffer<std::uint32_t> level_first_;
};

}  // namespace

bool triangles_intersect(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const auto named = [&](std::uint32_t t) {
    const std::uint32_t* v = mesh.triangles.data() + 3 * std::size_t{t};
    const auto at = [&](int i) { return mesh.vertices.data() + 3 * std::size_t{v[i]}; };
    return NamedTriangle{{v[0], v[1], v[2]}, {at(0), at(1), at(2)}};
  };
  return triangles_intersect(named(a), named(b));
}

bool triangles_intersect(const NamedTriangle& a, const NamedTriangle& b) {
  const Match& match = match_corners(a.vertex.data(), b.vertex.data());
  const Corners s = {a.at[match.a[0]], a.at[match.a[1]], a.at[match.a[2]]};
  const Corners t = {b.at[match.b[0]], b.at[match.b[1]], b.at[match.b[2]]};
  switch (match.common) {
    case 0:
      return disjoint_meet(s, t);
    case 1:
      return meet_beyond_vertex(s, t);
    case 2:
      return meet_beyond_edge(s, t);
    default:
      return true;
  }
}

std::vector<TrianglePair> candidate_pairs(Backend& backend, const TriangleMesh& mesh,
                                          const TriangleTree& tree) {
  if (tree.empty()) return {};
  const MeshView surface = {view_of(mesh.vertices), view_of(mesh.triangles)};
  const FlatTree flat(backend, tree);
  Buffer<std::uint32_t> starts(backend, tree.levels[0].size() + 1);
  const View<std::uint32_t> counts = starts.view().subview(0, tree.levels[0].size());
  backend.verify_count_pairs(surface, flat.view(), counts);
  const std::size_t count = backend.exclusive_scan(counts, starts.view());
  Buffer<std::uint32_t> found(backend, 2 * count);
  if (count > 0)
    backend.verify_collect_pairs(surface, flat.view(), std::as_const(starts).view(), found.view());
  std::vector<TrianglePair> pairs(count);
  const auto corners = backend.on_host(std::as_const(found).view());
  for (std::size_t i = 0; i < count; ++i)
    pairs[i] = {std::min(corners[2 * i], corners[2 * i + 1]),
                std::max(corners[2 * i], corners[2 * i + 1])};
  return pairs;
}

Intersections find_intersections(Backend& backend, const TriangleMesh& mesh,
                                 const TriangleTree& tree) {
  Intersections result;
  const std::vector<TrianglePair> pairs = candidate_pairs(backend, mesh, tree);
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<TrianglePair>& found) {
    for (std::size_t i = begin; i < end; ++i)
      if (triangles_intersect(mesh, pairs[i].first, pairs[i].second)) found.push_back(pairs[i]);
  };
  result.pairs = collect<TrianglePair>(backend, pairs.size(), kGrain, find);
  result.count = static_cast<std::int64_t>(result.pairs.size());
  keep_lowest(result.pairs);
  return result;
}

std::vector<Vec3> centres_of(const TriangleMesh& mesh, std::span<const TrianglePair> pairs) {
  std::vector<Vec3> centres;
  for (const TrianglePair& pair : pairs) {
    Vec3 centre;
    for (std::uint32_t t : {pair.first, pair.second})
      for (std::size_t i = 0; i < 3; ++i)
        centre = centre + (1.0f / 6) * vertex_at(mesh, mesh.triangles[3 * std::size_t{t} + i]);
    centres.push_back(centre);
  }
  return centres;
}

}  // namespace vasamesh

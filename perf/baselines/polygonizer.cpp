#include "polygonizer.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "vasamesh/errors.h"

namespace vasamesh::baselines {

namespace {

using Eigen::Vector3d;
using Node = std::array<int, 3>;

constexpr int kBisections = 10;
constexpr std::size_t kMostCubes = std::size_t{1} << 26;
constexpr int kHalfRange = 1 << 19;  // of a node's coordinates
constexpr int kEdges = 12;           // of a cube
constexpr int kNone = -1;

std::uint64_t key_of(const Node& node) {
  std::uint64_t key = 0;
  for (const int x : node) key = key << 20 | static_cast<std::uint64_t>(x + kHalfRange);
  return key;
}

// Corner c of a cube lies at its bits (x is bit 0). Edge 4 a + i runs along axis a from the i-th
// corner whose bit a is 0.
int corner_of(int axis, int i) {
  const int low = i & ((1 << axis) - 1), high = i >> axis;
  return high << (axis + 1) | low;
}
int edge_of(int from, int to) {
  const int bit = from ^ to, axis = bit == 1 ? 0 : bit == 2 ? 1 : 2, low = from & to;
  return 4 * axis + (low & ((1 << axis) - 1)) + (low >> (axis + 1) << axis);
}

/// The four corners of side 2 axis + high, counter-clockwise seen from outside the cube.
std::array<int, 4> side_corners(int axis, bool high) {
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = high ? 1 << axis : 0;
  if (high) return {base, base | u, base | u | v, base | v};
  return {base, base | v, base | u | v, base | u};
}

class Polygonizer {
 public:
  Polygonizer(const std::function<double(const Vector3d&)>& value, double cube)
      : value_(value), cube_(cube) {}

  TriangleMesh run(const std::vector<Vector3d>& seeds);

 private:
  bool inside(const Node& node);
  unsigned corners_inside(const Node& cube);
  void start_round(const Vector3d& seed);
  void visit(const Node& cube);
  void cut(const Node& cube, unsigned inside);
  std::uint32_t vertex(const Node& cube, int edge);

  const std::function<double(const Vector3d&)>& value_;
  const double cube_;
  std::unordered_map<std::uint64_t, bool> inside_;
  std::unordered_set<std::uint64_t> seen_;
  std::vector<Node> open_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;
  TriangleMesh mesh_;
};

Node moved(const Node& node, int axis, int by) {
  Node result = node;
  result[static_cast<std::size_t>(axis)] += by;
  return result;
}

Node corner_node(const Node& cube, int corner) {
  return {cube[0] + (corner & 1), cube[1] + (corner >> 1 & 1), cube[2] + (corner >> 2)};
}

Vector3d place_of(const Node& node, double cube) {
  return cube * Vector3d(node[0], node[1], node[2]);
}

bool Polygonizer::inside(const Node& node) {
  const auto [entry, is_new] = inside_.try_emplace(key_of(node), false);
  if (is_new) entry->second = value_(place_of(node, cube_)) < 0;
  return entry->second;
}

unsigned Polygonizer::corners_inside(const Node& cube) {
  unsigned mask = 0;
  for (int corner = 0; corner < 8; ++corner)
    if (inside(corner_node(cube, corner))) mask |= 1u << corner;
  return mask;
}

void Polygonizer::visit(const Node& cube) {
  if (!seen_.insert(key_of(cube)).second) return;
  open_.push_back(cube);
  if (seen_.size() > kMostCubes)
    throw Error(ErrorCode::refused, "the surface crosses more than 2^26 cubes: use larger ones");
}

/// The 27 cubes round the seed.
void Polygonizer::start_round(const Vector3d& seed) {
  for (int i = 0; i < 27; ++i) {
    Node cube;
    for (int a = 0, rest = i; a < 3; ++a, rest /= 3)
      cube[static_cast<std::size_t>(a)] =
          static_cast<int>(std::floor(seed[a] / cube_)) + rest % 3 - 1;
    const unsigned mask = corners_inside(cube);
    if (mask != 0 && mask != 0xff) visit(cube);
  }
}

TriangleMesh Polygonizer::run(const std::vector<Vector3d>& seeds) {
  for (const Vector3d& seed : seeds) start_round(seed);
  while (!open_.empty()) {
    const Node cube = open_.back();
    open_.pop_back();
    const unsigned mask = corners_inside(cube);
    cut(cube, mask);
    for (int side = 0; side < 6; ++side) {
      unsigned of_side = 0, here = 0;
      for (const int corner : side_corners(side / 2, side % 2 == 1)) {
        of_side |= 1u << corner;
        here |= mask & 1u << corner;
      }
      if (here != 0 && here != of_side) visit(moved(cube, side / 2, side % 2 == 1 ? 1 : -1));
    }
  }
  return std::move(mesh_);
}

/// On each side a line runs from an edge that goes outward to the next that goes inward, so that
/// the corners outside are cut off; the lines of a cube join to loops, and each loop is a fan.
void Polygonizer::cut(const Node& cube, unsigned inside) {
  std::array<int, kEdges> next;
  next.fill(kNone);
  for (int side = 0; side < 6; ++side) {
    const auto corners = side_corners(side / 2, side % 2 == 1);
    const auto is_inside = [&](int k) { return (inside >> corners[k % 4] & 1u) != 0; };
    for (int k = 0; k < 4; ++k) {
      if (!is_inside(k) || is_inside(k + 1)) continue;
      int back = k + 1;
      while (!is_inside(back + 1)) ++back;
      next[edge_of(corners[back % 4], corners[(back + 1) % 4])] =
          edge_of(corners[k], corners[(k + 1) % 4]);
    }
  }
  for (int first = 0; first < kEdges; ++first) {
    if (next[first] == kNone) continue;
    std::vector<std::uint32_t> loop;
    for (int edge = first; next[edge] != kNone;) {
      loop.push_back(vertex(cube, edge));
      edge = std::exchange(next[edge], kNone);
    }
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      mesh_.triangles.insert(mesh_.triangles.end(), {loop[0], loop[i], loop[i + 1]});
  }
}

std::uint32_t Polygonizer::vertex(const Node& cube, int edge) {
  const int axis = edge / 4, corner = corner_of(axis, edge % 4);
  const Node from = corner_node(cube, corner);
  const auto [entry, is_new] =
      vertices_.try_emplace(key_of(from) | static_cast<std::uint64_t>(axis) << 60,
                            static_cast<std::uint32_t>(mesh_.vertex_count()));
  if (!is_new) return entry->second;
  Vector3d in = place_of(from, cube_), out = place_of(moved(from, axis, 1), cube_);
  if (!inside(from)) std::swap(in, out);
  for (int i = 0; i < kBisections; ++i) {
    const Vector3d middle = 0.5 * (in + out);
    (value_(middle) < 0 ? in : out) = middle;
  }
  for (int a = 0; a < 3; ++a) mesh_.vertices.push_back(static_cast<float>(0.5 * (in[a] + out[a])));
  return entry->second;
}

}  // namespace

TriangleMesh polygonize(const std::function<double(const Vector3d&)>& value,
                        const Polygonization& options) {
  return Polygonizer(value, options.cube).run(options.seeds);
}

}  // namespace vasamesh::baselines

#include "stages/triangle_tree.h"

#include <algorithm>
#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 32768;  // triangles or nodes a task takes

Box triangle_box(const TriangleMesh& mesh, std::uint32_t triangle) {
  Box box;
  for (std::size_t i = 0; i < 3; ++i)
    box.take_in(vertex_at(mesh, mesh.triangles[3 * std::size_t{triangle} + i]));
  return box;
}

struct Keyed {
  std::uint32_t key, triangle;
};

/// Ten bits, two apart.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000ffu;
  bits = (bits | bits << 8) & 0x0300f00fu;
  bits = (bits | bits << 4) & 0x030c30c3u;
  return (bits | bits << 2) & 0x09249249u;
}

/// Place along the Morton curve, 1024 cells along the longest side of `whole`.
std::uint32_t morton_key(const Box& box, const Box& whole, float scale) {
  const Vec3 centre = 0.5f * box.low + 0.5f * box.high;
  const Vec3 cell = scale * (centre - whole.low);
  const auto part = [](float x) {
    return spread(static_cast<std::uint32_t>(std::clamp(x, 0.0f, 1023.0f)));
  };
  return part(cell.x) | part(cell.y) << 1 | part(cell.z) << 2;
}

/// Stable sort by the 30 bits of the keys.
void sort_by_key(const Backend& backend, std::vector<Keyed>& items) {
  constexpr int kDigit = 10;
  auto other = filled_in_steps<Keyed>(backend, items.size());
  for (int shift = 0; shift < 30; shift += kDigit) {
    std::array<std::uint32_t, (1 << kDigit) + 1> start{};
    const auto digit = [shift](const Keyed& item) {
      return item.key >> shift & ((1u << kDigit) - 1);
    };
    in_steps(backend, items.size(), [&](std::size_t i) { ++start[digit(items[i]) + 1]; });
    for (int d = 0; d < 1 << kDigit; ++d) start[d + 1] += start[d];
    in_steps(backend, items.size(),
             [&](std::size_t i) { other[start[digit(items[i])]++] = items[i]; });
    items.swap(other);
  }
}

void set_box(BoxNode& node, std::size_t i, const Box& box) {
  node.low[0][i] = box.low.x, node.low[1][i] = box.low.y, node.low[2][i] = box.low.z;
  node.high[0][i] = box.high.x, node.high[1][i] = box.high.y, node.high[2][i] = box.high.z;
}

/// Nodes over `count` boxes, eight each.
template <class BoxOf>
std::vector<BoxNode> make_level(Backend& backend, std::size_t count, const BoxOf& box) {
  auto nodes = filled_in_steps<BoxNode>(backend, (count + 7) / 8);
  for_each_index(backend, nodes.size(), kGrain, [&](std::size_t n) {
    for (std::size_t i = 0; i < 8; ++i)
      set_box(nodes[n], i, 8 * n + i < count ? box(8 * n + i) : Box{});
  });
  return nodes;
}

std::vector<std::uint32_t> morton_order(Backend& backend, const TriangleMesh& mesh,
                                        const std::vector<std::uint8_t>& keep) {
  std::vector<Keyed> items;
  items.reserve(mesh.triangle_count());
  in_steps(backend, mesh.triangle_count(), [&](std::size_t t) {
    if (keep.empty() || keep[t]) items.push_back({0, static_cast<std::uint32_t>(t)});
  });
  const auto joined = [](Box box, const Box& other) {
    box.take_in(other);
    return box;
  };
  const auto box_round = [&](std::size_t begin, std::size_t end) {
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.take_in(triangle_box(mesh, items[i].triangle));
    return box;
  };
  const Box whole = reduce_ranges(backend, items.size(), kGrain, Box{}, box_round, joined);
  const float side = whole.longest_side();
  const float scale = side > 0 ? 1024.0f / side : 0.0f;
  for_each_index(backend, items.size(), kGrain, [&](std::size_t i) {
    items[i].key = morton_key(triangle_box(mesh, items[i].triangle), whole, scale);
  });
  sort_by_key(backend, items);
  auto order = filled_in_steps<std::uint32_t>(backend, items.size());
  in_steps(backend, items.size(), [&](std::size_t i) { order[i] = items[i].triangle; });
  return order;
}

TriangleTree tree_over(Backend& backend, const TriangleMesh& mesh,
                       std::vector<std::uint32_t> order) {
  TriangleTree tree;
  tree.order = std::move(order);
  if (tree.order.empty()) return tree;
  tree.levels.push_back(make_level(backend, tree.order.size(), [&](std::size_t i) {
    return triangle_box(mesh, tree.order[i]);
  }));
  while (tree.levels.back().size() > 1) {
    const std::vector<BoxNode>& below = tree.levels.back();
    tree.levels.push_back(
        make_level(backend, below.size(), [&](std::size_t i) { return box_of(below[i]); }));
  }
  return tree;
}

}  // namespace

Box box_of(const BoxNode& node) {
  Box box;
  for (int i = 0; i < 8; ++i) box.take_in(box_of(node, i));
  return box;
}

TriangleTree build_triangle_tree(Backend& backend, const TriangleMesh& mesh,
                                 const std::vector<std::uint8_t>& keep) {
  return tree_over(backend, mesh, morton_order(backend, mesh, keep));
}

TriangleTree build_tree_in_order(Backend& backend, const TriangleMesh& mesh) {
  auto order = filled_in_steps<std::uint32_t>(backend, mesh.triangle_count());
  in_steps(backend, order.size(), [&](std::size_t i) { order[i] = static_cast<std::uint32_t>(i); });
  return tree_over(backend, mesh, std::move(order));
}

}  // namespace vasamesh

#include "reference/surface_reference.h"

#include <algorithm>

namespace vasamesh::reference {

namespace {

using Node = std::array<int, 3>;

LatticeEdge edge(const Node& a, const Node& b) {
  return a < b ? LatticeEdge{a, b} : LatticeEdge{b, a};
}

/// Six times the signed volume of a tetrahedron.
int orientation(const Node& a, const Node& b, const Node& c, const Node& d) {
  Node u, v, w;
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = b[i] - a[i];
    v[i] = c[i] - a[i];
    w[i] = d[i] - a[i];
  }
  return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
         u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/// The triangles of one tetrahedron. With `a` the lone node inside and (a, b, c, d) positively
/// oriented, the triangle over the edges ab, ac, ad faces away from a.
void add_tetrahedron(std::array<Node, 4> n, const test::DenseVolume& nodes,
                     std::vector<EdgeTriangle>& triangles) {
  const auto inside = [&](const Node& p) { return nodes.object(p[0], p[1], p[2]); };
  const auto middle = std::stable_partition(n.begin(), n.end(), inside);
  const auto count = middle - n.begin();
  if (count == 0 || count == 4) return;
  const bool positive = orientation(n[0], n[1], n[2], n[3]) > 0;
  std::vector<LatticeEdge> ring;
  if (count == 1) ring = {edge(n[0], n[1]), edge(n[0], n[2]), edge(n[0], n[3])};
  if (count == 3) ring = {edge(n[3], n[0]), edge(n[3], n[1]), edge(n[3], n[2])};
  if (count == 2) ring = {edge(n[0], n[2]), edge(n[0], n[3]), edge(n[1], n[3]), edge(n[1], n[2])};
  if (!positive) std::reverse(ring.begin() + 1, ring.end());
  triangles.push_back(turned({ring[0], ring[1], ring[2]}));
  if (count == 2) triangles.push_back(turned({ring[0], ring[2], ring[3]}));
}

}  // namespace

EdgeTriangle turned(const EdgeTriangle& triangle) {
  EdgeTriangle result = triangle;
  std::rotate(result.begin(), std::min_element(result.begin(), result.end()), result.end());
  return result;
}

std::vector<EdgeTriangle> marching_tetrahedra(const test::DenseVolume& nodes) {
  std::vector<EdgeTriangle> triangles;
  for (int z = 0; z + 1 < nodes.size[2]; ++z)
    for (int y = 0; y + 1 < nodes.size[1]; ++y)
      for (int x = 0; x + 1 < nodes.size[0]; ++x) {
        std::array<int, 3> order = {0, 1, 2};
        do {
          std::array<Node, 4> path;
          path[0] = {x, y, z};
          for (std::size_t i = 0; i < 3; ++i) {
            path[i + 1] = path[i];
            ++path[i + 1][static_cast<std::size_t>(order[i])];
          }
          add_tetrahedron(path, nodes, triangles);
        } while (std::next_permutation(order.begin(), order.end()));
      }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace vasamesh::reference

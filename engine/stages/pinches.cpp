#include "stages/pinches.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "stages/adjacency.h"
#include "stages/disjoint_sets.h"

namespace vasamesh {

namespace {

std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/// The fans of a mesh, as sets of corners: of triangles at a vertex that share an edge there.
DisjointSets find_fans(const TriangleMesh& mesh) {
  struct Edge {
    std::uint64_t ends;    // lower vertex first
    std::uint32_t corner;  // where a triangle begins it
    bool operator<(const Edge& other) const {
      return ends != other.ends ? ends < other.ends : corner < other.corner;
    }
  };
  std::vector<Edge> edges(mesh.triangles.size());
  for (std::uint32_t c = 0; c < edges.size(); ++c) {
    const std::uint64_t a = mesh.triangles[c], b = mesh.triangles[next_corner(c)];
    edges[c] = {std::min(a, b) << 32 | std::max(a, b), c};
  }
  std::sort(edges.begin(), edges.end());
  DisjointSets fans(mesh.triangles.size());
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (edges[i].ends != edges[i - 1].ends) continue;
    const std::uint32_t a = edges[i - 1].corner, b = edges[i].corner;
    if (mesh.triangles[a] == mesh.triangles[b]) continue;  // of one direction: no pair
    fans.unite(a, next_corner(b));
    fans.unite(next_corner(a), b);
  }
  return fans;
}

}  // namespace

bool drop_repeated_edges(TriangleMesh& mesh) {
  const VertexCorners at = vertex_corners(mesh);
  std::vector<std::uint8_t> dropped(mesh.triangle_count(), 0);
  bool any = false;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (std::uint32_t i = at.first[v]; i < at.first[v + 1]; ++i)
      for (std::uint32_t j = at.first[v]; j < i; ++j) {
        const std::uint32_t a = at.corner[i], b = at.corner[j];
        if (mesh.triangles[next_corner(a)] != mesh.triangles[next_corner(b)]) continue;
        dropped[a / 3] = dropped[b / 3] = 1;
        any = true;
      }
  if (!any) return false;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < dropped.size(); ++t) {
    if (dropped[t]) continue;
    std::copy_n(&mesh.triangles[3 * t], 3, &mesh.triangles[3 * kept]);
    ++kept;
  }
  mesh.triangles.resize(3 * kept);
  return true;
}

void split_pinches(TriangleMesh& mesh) {
  constexpr std::uint32_t kNone = 0xffffffffu;
  DisjointSets fans = find_fans(mesh);
  std::vector<std::uint32_t> first_fan(mesh.vertex_count(), kNone);
  std::vector<std::uint32_t> vertex_of(mesh.triangles.size());
  for (std::uint32_t c = 0; c < vertex_of.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c], fan = fans.root(c);
    if (fan != c) {
      vertex_of[c] = vertex_of[fan];
    } else if (first_fan[v] == kNone) {
      first_fan[v] = fan;
      vertex_of[c] = v;
    } else {
      vertex_of[c] = static_cast<std::uint32_t>(mesh.vertex_count());
      for (std::size_t a = 0; a < 3; ++a)
        mesh.vertices.push_back(mesh.vertices[3 * std::size_t{v} + a]);
    }
  }
  mesh.triangles = std::move(vertex_of);
}

}  // namespace vasamesh

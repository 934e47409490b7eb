#include "stages/pinches.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "stages/disjoint_sets.h"

namespace vasamesh {

namespace {

std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

std::uint32_t previous_corner(std::uint32_t corner) {
  return corner % 3 == 0 ? corner + 2 : corner - 1;
}

/// The corners of a fan, ascending.
using Fan = std::vector<std::uint32_t>;

/// Appends the fans at a vertex, of triangles that share edges there, but for the first.
void find_further_fans(const TriangleMesh& mesh, std::span<const std::uint32_t> corners,
                       std::vector<Fan>& fans) {
  DisjointSets sets(corners.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i)
    for (std::uint32_t j = 0; j < corners.size(); ++j)
      if (mesh.triangles[next_corner(corners[i])] == mesh.triangles[previous_corner(corners[j])])
        sets.unite(i, j);
  const std::vector<std::uint32_t> root = std::move(sets).roots();
  const std::size_t known = fans.size();
  for (std::uint32_t i = 0; i < root.size(); ++i) {
    if (root[i] == 0) continue;
    if (root[i] == i) fans.emplace_back();
    const auto own = std::find_if(
        fans.begin() + static_cast<std::ptrdiff_t>(known), fans.end(),
        [&](const Fan& fan) { return fan.empty() || fan.front() == corners[root[i]]; });
    own->push_back(corners[i]);
  }
}

}  // namespace

bool drop_repeated_edges(const Backend& backend, TriangleMesh& mesh) {
  const VertexCorners at = vertex_corners(backend, mesh);
  std::vector<std::uint8_t> dropped(mesh.triangle_count(), 0);
  bool any = false;
  in_steps(backend, mesh.vertex_count(), [&](std::size_t v) {
    for (std::uint32_t i = at.first[v]; i < at.first[v + 1]; ++i)
      for (std::uint32_t j = at.first[v]; j < i; ++j) {
        const std::uint32_t a = at.corner[i], b = at.corner[j];
        if (mesh.triangles[next_corner(a)] != mesh.triangles[next_corner(b)]) continue;
        dropped[a / 3] = dropped[b / 3] = 1;
        any = true;
      }
  });
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

void split_pinches(Backend& backend, TriangleMesh& mesh) {
  constexpr std::size_t kGrain = 4096;  // vertices a task takes
  const VertexCorners at = vertex_corners(backend, mesh);
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<Fan>& found) {
    for (std::size_t v = begin; v < end; ++v)
      find_further_fans(
          mesh, std::span(at.corner).subspan(at.first[v], at.first[v + 1] - at.first[v]), found);
  };
  std::vector<Fan> fans = collect<Fan>(backend, mesh.vertex_count(), kGrain, find);
  std::sort(fans.begin(), fans.end());
  for (const Fan& fan : fans) {
    const auto copy = static_cast<std::uint32_t>(mesh.vertex_count());
    const std::size_t old = mesh.triangles[fan.front()];
    for (std::size_t a = 0; a < 3; ++a) mesh.vertices.push_back(mesh.vertices[3 * old + a]);
    for (const std::uint32_t corner : fan) mesh.triangles[corner] = copy;
  }
}

}  // namespace vasamesh

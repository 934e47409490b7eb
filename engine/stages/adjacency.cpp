#include "stages/adjacency.h"

#include <algorithm>
#include <utility>

#include "stages/disjoint_sets.h"
#include "vasamesh/errors.h"

namespace vasamesh {

VertexCorners vertex_corners(const TriangleMesh& mesh) {
  if (mesh.triangles.size() > 0xffffffffu)
    throw Error(ErrorCode::refused, "the surface has more than 2^32 corners: take a part of it");
  VertexCorners result;
  // Counts go two entries on; after the scan, entry v + 1 runs from the start of v to its end.
  result.first.assign(mesh.vertex_count() + 2, 0);
  for (std::uint32_t v : mesh.triangles) ++result.first[v + 2];
  for (std::size_t v = 2; v < result.first.size(); ++v) result.first[v] += result.first[v - 1];
  result.corner.resize(mesh.triangles.size());
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    result.corner[result.first[mesh.triangles[c] + 1]++] = static_cast<std::uint32_t>(c);
  result.first.pop_back();
  return result;
}

std::vector<std::uint32_t> connect_vertices(Backend& backend, const TriangleMesh& mesh,
                                            std::span<const std::uint8_t> chosen) {
  constexpr std::size_t kTask = 16384;  // triangles
  DisjointSets sets(mesh.vertex_count());
  const std::size_t count = mesh.triangle_count();
  backend.run((count + kTask - 1) / kTask, [&](std::size_t task) {
    for (std::size_t t = task * kTask; t < std::min((task + 1) * kTask, count); ++t) {
      if (!chosen.empty() && !chosen[t]) continue;
      sets.unite(mesh.triangles[3 * t], mesh.triangles[3 * t + 1]);
      sets.unite(mesh.triangles[3 * t], mesh.triangles[3 * t + 2]);
    }
  });
  return std::move(sets).roots();
}

}  // namespace vasamesh

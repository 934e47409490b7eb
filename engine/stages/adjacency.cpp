#include "stages/adjacency.h"

#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/disjoint_sets.h"
#include "vasamesh/errors.h"

namespace vasamesh {

VertexCorners vertex_corners(const Backend& backend, const TriangleMesh& mesh) {
  if (mesh.triangles.size() > 0xffffffffu)
    throw Error(ErrorCode::refused, "the surface has more than 2^32 corners: take a part of it");
  VertexCorners result;
  // Counts go two entries on; after the scan, entry v + 1 runs from the start of v to its end.
  resize_in_steps(backend, mesh.vertex_count() + 2, result.first);
  const std::size_t corners = mesh.triangles.size();
  in_steps(backend, corners, [&](std::size_t c) { ++result.first[mesh.triangles[c] + 2]; });
  in_steps(backend, mesh.vertex_count(),
           [&](std::size_t v) { result.first[v + 2] += result.first[v + 1]; });
  resize_in_steps(backend, corners, result.corner);
  in_steps(backend, corners, [&](std::size_t c) {
    result.corner[result.first[mesh.triangles[c] + 1]++] = static_cast<std::uint32_t>(c);
  });
  result.first.pop_back();
  return result;
}

std::vector<std::uint32_t> connect_vertices(Backend& backend, const TriangleMesh& mesh,
                                            std::span<const std::uint8_t> chosen) {
  constexpr std::size_t kGrain = 16384;  // triangles a task takes
  DisjointSets sets(mesh.vertex_count());
  for_each_index(backend, mesh.triangle_count(), kGrain, [&](std::size_t t) {
    if (!chosen.empty() && !chosen[t]) return;
    sets.unite(mesh.triangles[3 * t], mesh.triangles[3 * t + 1]);
    sets.unite(mesh.triangles[3 * t], mesh.triangles[3 * t + 2]);
  });
  return std::move(sets).roots();
}

}  // namespace vasamesh

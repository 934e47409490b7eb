#include "stages/adjacency.h"

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

}  // namespace vasamesh

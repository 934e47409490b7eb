#pragma once

/// \file
/// Parts of surfaces as they are remeshed, from meshes and back.

#include <cstdint>
#include <utility>
#include <vector>

#include "stages/patch_mesh.h"
#include "types/mesh_vertex.h"
#include "vasamesh/types.h"

namespace vasamesh::test {

/// \param whole  whether a vertex at that place is.
template <class Whole>
PatchMesh patch_of(const TriangleMesh& mesh, const Whole& whole) {
  std::vector<SurfacePoint> points(mesh.vertex_count());
  std::vector<std::uint8_t> flags;
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v].position = vertex_at(mesh, v);
    flags.push_back(whole(points[v].position));
  }
  PatchMesh patch;
  patch.build(std::move(points), mesh.triangles, std::move(flags));
  return patch;
}

/// All vertices are whole.
inline PatchMesh patch_of(const TriangleMesh& mesh) {
  return patch_of(mesh, [](const Vec3&) { return true; });
}

/// With the vertices that are gone, in no triangle.
inline TriangleMesh mesh_of(const PatchMesh& patch) {
  TriangleMesh mesh;
  for (const SurfacePoint& point : patch.points)
    mesh.vertices.insert(mesh.vertices.end(),
                         {point.position.x, point.position.y, point.position.z});
  for (std::uint32_t h = 0; h < patch.half_edge_end(); h += 4)
    if (patch.is_edge(h))
      for (const std::uint32_t v : patch.corners(h)) mesh.triangles.push_back(v);
  return mesh;
}

}  // namespace vasamesh::test

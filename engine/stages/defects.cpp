#include "stages/defects.h"

#include <algorithm>
#include <cmath>

#include "stages/curvature.h"
#include "stages/distance.h"
#include "stages/intersect.h"
#include "stages/places.h"
#include "stages/remesh.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

std::int64_t euler_number(const TriangleMesh& closed) {
  return static_cast<std::int64_t>(closed.vertex_count()) -
         static_cast<std::int64_t>(closed.triangle_count() / 2);
}

/// The first vertices of the edges that have not one triangle on each side.
std::vector<std::uint32_t> bad_edges(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> edges;
  edges.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back(std::uint64_t{mesh.triangles[3 * t + i]} << 32 |
                      mesh.triangles[3 * t + (i + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> bad;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const std::uint64_t back = edges[i] << 32 | edges[i] >> 32;
    const auto [first, last] = std::equal_range(edges.begin(), edges.end(), back);
    if (last - first != 1 || (i > 0 && edges[i] == edges[i - 1]))
      bad.push_back(static_cast<std::uint32_t>(edges[i] >> 32));
  }
  return bad;
}

bool is_in_cube(const Vec3& middle, const Vec3& p) {
  const Vec3 off = p - middle;
  return std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}) <= kCurvatureCube / 2;
}

/// Appends the vertex of `from` in the cube that is farthest from the other surface, if any.
void add_farthest(Backend& backend, const Vec3& middle, const TriangleMesh& from,
                  const TriangleMesh& to, const TriangleTree& tree, std::vector<Vec3>& found) {
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < from.vertex_count(); ++v)
    if (is_in_cube(middle, vertex_at(from, v))) points.push_back(vertex_at(from, v));
  const std::vector<float> distances = distances_to(backend, points, to, tree);
  const auto farthest = std::max_element(distances.begin(), distances.end());
  if (farthest != distances.end())
    found.push_back(points[static_cast<std::size_t>(farthest - distances.begin())]);
}

}  // namespace

bool has_topology_of(const TriangleMesh& base, const TriangleMesh& mesh) {
  return euler_number(mesh) == euler_number(base) && bad_edges(mesh).empty();
}

std::vector<Vec3> find_defects(Backend& backend, const TriangleMesh& base,
                               const TriangleTree& base_tree, const TriangleMesh& mesh,
                               bool meets_itself) {
  std::vector<Vec3> found;
  for (const std::uint32_t v : bad_edges(mesh)) found.push_back(vertex_at(mesh, v));
  if (!meets_itself && !found.empty()) return found;
  const TriangleTree tree = build_triangle_tree(backend, mesh);
  if (meets_itself) {
    const Intersections pairs = find_intersections(backend, mesh, tree);
    for (const CarefulPlace& place : places_at(centres_of(mesh, pairs.pairs), 1, 1))
      found.push_back(place.centre);
  }
  if (!found.empty()) return found;
  for (const Vec3& middle : curvature_differences(backend, base, mesh)) {
    add_farthest(backend, middle, base, mesh, tree, found);
    add_farthest(backend, middle, mesh, base, base_tree, found);
  }
  return found;
}

}  // namespace vasamesh

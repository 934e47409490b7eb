#include "stages/defects.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "stages/angle_defects.h"
#include "stages/distance.h"
#include "stages/intersect.h"
#include "stages/places.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kFarShare = 0.5f;     // of the largest distance
constexpr std::size_t kGrain = 4096;  // vertices a task takes

std::int64_t euler_number(const TriangleMesh& closed) {
  return static_cast<std::int64_t>(closed.vertex_count()) -
         static_cast<std::int64_t>(closed.triangle_count() / 2);
}

/// The first vertices of the edges that have not one triangle on each side.
std::vector<std::uint32_t> bad_edges(Backend& backend, const TriangleMesh& mesh) {
  const VertexCorners corners = vertex_corners(backend, mesh);
  const auto next_of = [&](std::uint32_t c) { return mesh.triangles[c % 3 == 2 ? c - 2 : c + 1]; };
  const auto count_to = [&](std::span<const std::uint32_t> some, std::uint32_t v) {
    return std::count_if(some.begin(), some.end(),
                         [&](std::uint32_t c) { return next_of(c) == v; });
  };
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& bad) {
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
      const std::span<const std::uint32_t> from = corners.at(v);
      for (std::size_t i = 0; i < from.size(); ++i) {
        const std::uint32_t w = next_of(from[i]);
        if (count_to(corners.at(w), v) != 1 || count_to(from.first(i), w) > 0) bad.push_back(v);
      }
    }
  };
  return collect<std::uint32_t>(backend, mesh.vertex_count(), kGrain, find);
}

bool is_in_cube(const Vec3& middle, const Vec3& p) {
  const Vec3 off = p - middle;
  return std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}) <= kAngleDefectCube / 2;
}

/// Appends the vertices of `from` in the cube that are farthest from the other surface, or half as
/// far: what one surface lacks is more than one place.
void add_farthest(Backend& backend, const Vec3& middle, const TriangleMesh& from,
                  const TriangleMesh& to, const TriangleTree& tree, std::vector<Vec3>& found) {
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < from.vertex_count(); ++v)
    if (is_in_cube(middle, vertex_at(from, v))) points.push_back(vertex_at(from, v));
  const std::vector<float> distances = distances_to(backend, points, to, tree);
  if (points.empty()) return;
  const float far = kFarShare * *std::max_element(distances.begin(), distances.end());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (distances[i] >= far) found.push_back(points[i]);
}

}  // namespace

bool has_topology_of(Backend& backend, const TriangleMesh& base, const TriangleMesh& mesh) {
  return euler_number(mesh) == euler_number(base) && bad_edges(backend, mesh).empty();
}

std::vector<Vec3> find_defects(Backend& backend, const TriangleMesh& base,
                               const TriangleTree& base_tree, const TriangleMesh& mesh,
                               bool meets_itself) {
  std::vector<Vec3> found;
  for (const std::uint32_t v : bad_edges(backend, mesh)) found.push_back(vertex_at(mesh, v));
  if (!meets_itself && !found.empty()) return found;
  const TriangleTree tree = build_triangle_tree(backend, mesh);
  if (meets_itself) {
    const Intersections pairs = find_intersections(backend, mesh, tree);
    for (const CarefulPlace& place : places_at(centres_of(mesh, pairs.pairs), 1, 1))
      found.push_back(place.centre);
  }
  if (!found.empty()) return found;
  for (const Vec3& middle : angle_defect_differences(backend, base, mesh)) {
    add_farthest(backend, middle, base, mesh, tree, found);
    add_farthest(backend, middle, mesh, base, base_tree, found);
  }
  return found;
}

}  // namespace vasamesh

#include "reference/exact_intersections.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <algorithm>
#include <array>

#ifdef VASAMESH_GPL_ORACLES
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#endif

namespace vasamesh::test {

namespace {

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;

Exact::Triangle_3 triangle(const TriangleMesh& mesh, std::uint32_t t) {
  const auto corner = [&](int i) {
    const float* p = mesh.vertices.data() + 3 * mesh.triangles[3 * t + i];
    return Exact::Point_3(p[0], p[1], p[2]);
  };
  return {corner(0), corner(1), corner(2)};
}

int shared_vertices(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) shared += mesh.triangles[3 * a + i] == mesh.triangles[3 * b + j];
  return shared;
}

}  // namespace

bool is_degenerate(const TriangleMesh& mesh, std::uint32_t t) {
  return triangle(mesh, t).is_degenerate();
}

bool intersect_exactly(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const auto common = CGAL::intersection(triangle(mesh, a), triangle(mesh, b));
  switch (shared_vertices(mesh, a, b)) {
    case 0:
      return common.has_value();
    case 1:
      return boost::get<Exact::Point_3>(&common.value()) == nullptr;
    case 2:
      return boost::get<Exact::Segment_3>(&common.value()) == nullptr;
    default:
      return true;
  }
}

std::vector<TrianglePair> all_exact_intersections(const TriangleMesh& mesh) {
  std::vector<TrianglePair> pairs;
  const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (!is_degenerate(mesh, a) && !is_degenerate(mesh, b) && intersect_exactly(mesh, a, b))
        pairs.push_back({a, b});
  return pairs;
}

#ifdef VASAMESH_GPL_ORACLES

std::vector<TrianglePair> cgal_intersections(const TriangleMesh& mesh) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  CGAL::Surface_mesh<Kernel::Point_3> surface;
  using Vertex = decltype(surface)::Vertex_index;
  using Face = decltype(surface)::Face_index;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const float* p = mesh.vertices.data() + 3 * v;
    surface.add_vertex({p[0], p[1], p[2]});
  }
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    surface.add_face(Vertex(mesh.triangles[3 * t]), Vertex(mesh.triangles[3 * t + 1]),
                     Vertex(mesh.triangles[3 * t + 2]));
  std::vector<std::pair<Face, Face>> found;
  CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(found));
  std::vector<TrianglePair> pairs;
  for (const auto& [a, b] : found) {
    const auto i = static_cast<std::uint32_t>(a), j = static_cast<std::uint32_t>(b);
    pairs.push_back({std::min(i, j), std::max(i, j)});
  }
  std::sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
    return std::array{a.first, a.second} < std::array{b.first, b.second};
  });
  return pairs;
}

#endif

}  // namespace vasamesh::test

#include "support/broken_meshes.h"

#include <limits>

#include "support/shapes.h"

namespace vasamesh::test {

namespace {

TriangleMesh small_sphere() { return sphere(2, 1); }

/// A vertex of the second mesh taken for one of the first.
TriangleMesh welded(TriangleMesh mesh, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t& v : mesh.triangles) v = v == from ? to : v > from ? v - 1 : v;
  mesh.vertices.erase(mesh.vertices.begin() + 3 * from, mesh.vertices.begin() + 3 * from + 3);
  return mesh;
}

BrokenMesh hole() {
  TriangleMesh mesh = small_sphere();
  mesh.triangles.resize(mesh.triangles.size() - 3);
  return {"hole", mesh, {.open_edges = 3}};
}

BrokenMesh flipped_triangle() {
  TriangleMesh mesh = small_sphere();
  std::swap(mesh.triangles[16], mesh.triangles[17]);
  return {"flipped_triangle", mesh, {.misoriented_edges = 3}};
}

BrokenMesh duplicated_triangle() {
  TriangleMesh mesh = small_sphere();
  add_triangle(mesh, mesh.triangles[31], mesh.triangles[32], mesh.triangles[30]);
  return {"duplicated_triangle", mesh, {.nonmanifold_edges = 3, .intersecting_pairs = 1}};
}

BrokenMesh bow_tie() {
  const TriangleMesh two = joined(tetrahedron(), moved(tetrahedron(), {1, 0, 0}));
  return {"bow_tie", welded(two, 4, 1), {.nonmanifold_vertices = 1}};
}

BrokenMesh edge_of_four_triangles() {
  TriangleMesh other = tetrahedron();
  for (std::size_t i = 0; i < other.vertices.size(); ++i)
    if (i % 3 != 2) other.vertices[i] *= -1;  // half a turn round the z axis, where they meet
  const TriangleMesh two = joined(tetrahedron(), other);
  return {"edge_of_four_triangles", welded(welded(two, 7, 3), 4, 0), {.nonmanifold_edges = 1}};
}

BrokenMesh fin() {
  TriangleMesh mesh = small_sphere();
  add_triangle(mesh, mesh.triangles[0], mesh.triangles[1], add_vertex(mesh, {5, 6, 7}));
  return {"fin", mesh, {.open_edges = 2, .nonmanifold_edges = 1}};
}

BrokenMesh isolated_vertex() {
  TriangleMesh mesh = small_sphere();
  add_vertex(mesh, {0, 0, 0});
  return {"isolated_vertex", mesh, {.isolated_vertices = 1}};
}

BrokenMesh repeated_vertex() {
  TriangleMesh mesh = small_sphere();
  add_triangle(mesh, 3, 9, 3);
  return {"repeated_vertex", mesh, {.degenerate_triangles = 1}};
}

/// A vertex in the middle of one side of an edge: the sliver between is a line, and the other
/// side's triangle meets both halves along it.
BrokenMesh collinear_triangle() {
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  const std::uint32_t middle = add_vertex(mesh, {0.5f, 0, 0});  // of the edge from 0 to 1
  std::vector<std::uint32_t> triangles;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
    if (a == 0 && b == 1)
      triangles.insert(triangles.end(), {a, middle, c, middle, b, c, a, b, middle});
    else
      triangles.insert(triangles.end(), {a, b, c});
  }
  mesh.triangles = triangles;
  return {"collinear_triangle", mesh, {.degenerate_triangles = 1, .intersecting_pairs = 2}};
}

BrokenMesh not_finite(const char* name, float value) {
  TriangleMesh mesh = small_sphere();
  mesh.vertices[40] = value;
  return {name, mesh, {.nonfinite_vertices = 1}};
}

BrokenMesh inside_out() {
  return {"inside_out", turned_inside_out(small_sphere()), {.inverted_shells = 1}};
}

BrokenMesh outward_in_outward() {
  return {"outward_in_outward", joined(sphere(1, 1), sphere(2, 1)), {.inverted_shells = 1}};
}

/// A box whose upper side is a fan round a vertex.
TriangleMesh box_with_fan(const Vertex& apex) {
  TriangleMesh mesh = box({0, 0, 0}, {2, 2, 2});
  mesh.triangles.resize(mesh.triangles.size() - 6);
  const std::uint32_t v = add_vertex(mesh, apex);
  constexpr std::uint32_t kRim[5] = {4, 5, 7, 6, 4};
  for (int i = 0; i < 4; ++i) add_triangle(mesh, kRim[i], kRim[i + 1], v);
  return mesh;
}

}  // namespace

Defects defects_of(const CheckReport& r) {
  return {r.open_edges,           r.nonmanifold_edges,  r.misoriented_edges,
          r.nonmanifold_vertices, r.isolated_vertices,  r.degenerate_triangles,
          r.nonfinite_vertices,   r.intersecting_pairs, r.inverted_shells};
}

std::vector<BrokenMesh> badly_joined_meshes() {
  return {hole(),
          flipped_triangle(),
          duplicated_triangle(),
          bow_tie(),
          edge_of_four_triangles(),
          fin(),
          isolated_vertex(),
          repeated_vertex(),
          collinear_triangle(),
          not_finite("not_a_number", std::numeric_limits<float>::quiet_NaN()),
          not_finite("infinite", std::numeric_limits<float>::infinity()),
          inside_out(),
          outward_in_outward()};
}

std::vector<NamedMesh> self_intersecting_meshes() {
  const TriangleMesh cube = box({0, 0, 0}, {2, 2, 2});
  return {{"needle_through_two_sides", joined(cube, box({-1, 1.25f, 0.5f}, {3, 1.5f, 0.625f}))},
          {"base_on_face", joined(cube, moved(tetrahedron(), {1.25f, 0.5f, 2}))},
          {"vertex_on_face", joined(cube, moved(tetrahedron(), {0.75f, -1, 0.5f}))},
          {"vertex_on_vertex", joined(cube, moved(tetrahedron(), {2, 2, 2}))},
          {"edge_on_edge", joined(cube, moved(cube, {2, 0.5f, 2}))},
          {"face_on_face", joined(cube, moved(cube, {2, 0.5f, 0.5f}))},
          {"same_place", joined(cube, cube)},
          {"folded_in_plane", box_with_fan({1, 3, 2})},
          {"pushed_through_floor", box_with_fan({1, 0.75f, -1})},
          {"pushed_through_wall", box_with_fan({3, 0.75f, 1})}};
}

}  // namespace vasamesh::test

#include "support/gaps.h"

#include <algorithm>

#include "stages/bridge.h"

namespace vasamesh::test {

Backend& two_threads() {
  static const std::shared_ptr<Backend> tbb = make_tbb_backend(2, nullptr);
  return *tbb;
}

Scene& ball() {
  static Scene scene{sphere_field(24, {12, 12, 12}, 8), moved(sphere(8, 3), {12, 12, 12}), 1.15f};
  return scene;
}

Scene& ring() {
  static Scene scene{torus_field(32, {16, 16, 16}, 10, 3),
                     moved(torus(10, 3, 62, 19), {16, 16, 16}), 1.0f};
  return scene;
}

StitchReport stitch(Scene& scene, TriangleMesh& mesh, StitchMode mode) {
  return stitch_gaps(two_threads(), scene.field.view(), scene.field.sizes(scene.size), mode, mesh);
}

TriangleMesh without(const TriangleMesh& mesh, const std::vector<bool>& removed) {
  constexpr std::uint32_t kUnused = 0xffffffffu;
  std::vector<std::uint32_t> moved_to(mesh.vertex_count(), kUnused);
  TriangleMesh rest;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (removed[t]) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t v = mesh.triangles[3 * t + i];
      if (moved_to[v] == kUnused) {
        const float* p = mesh.vertices.data() + 3 * std::size_t{v};
        moved_to[v] = add_vertex(rest, {p[0], p[1], p[2]});
      }
      rest.triangles.push_back(moved_to[v]);
    }
  }
  return rest;
}

TriangleMesh with_random_holes(const TriangleMesh& mesh, int holes, int largest, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<std::uint32_t>> at_vertex(mesh.vertex_count());
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    at_vertex[mesh.triangles[c]].push_back(static_cast<std::uint32_t>(c / 3));
  std::vector<bool> removed(mesh.triangle_count(), false);
  for (int hole = 0; hole < holes; ++hole) {
    const std::size_t wanted = 1 + random() % largest;
    std::vector<std::uint32_t> patch{static_cast<std::uint32_t>(random() % mesh.triangle_count())};
    for (int trial = 0; patch.size() < wanted && trial < 20 * largest; ++trial) {
      const std::uint32_t from = patch[random() % patch.size()];
      const auto& near = at_vertex[mesh.triangles[3 * from + random() % 3]];
      const std::uint32_t to = near[random() % near.size()];
      int shared = 0;
      for (int i = 0; i < 9; ++i)
        shared += mesh.triangles[3 * from + i / 3] == mesh.triangles[3 * to + i % 3];
      if (shared == 2 && std::find(patch.begin(), patch.end(), to) == patch.end())
        patch.push_back(to);
    }
    for (const std::uint32_t t : patch) removed[t] = true;
  }
  return without(mesh, removed);
}

std::multiset<Edge> directed_edges(const TriangleMesh& mesh) {
  std::multiset<Edge> edges;
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    edges.insert({mesh.triangles[c], mesh.triangles[c % 3 == 2 ? c - 2 : c + 1]});
  return edges;
}

float turning_of(AnalyticField& field, const TriangleMesh& mesh,
                 std::span<const std::uint32_t> loop) {
  std::vector<Vec3> points, normals;
  for (const std::uint32_t v : loop) {
    points.push_back(vertex_at(mesh, v));
    normals.push_back(normalised(-sample_field(field.view(), points.back()).gradient));
  }
  return turning(points, normals);
}

}  // namespace vasamesh::test

#include "support/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace vasamesh::test {

std::uint32_t add_vertex(TriangleMesh& mesh, const Vertex& p) {
  mesh.vertices.insert(mesh.vertices.end(), p.begin(), p.end());
  return static_cast<std::uint32_t>(mesh.vertex_count() - 1);
}

void add_triangle(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  mesh.triangles.insert(mesh.triangles.end(), {a, b, c});
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (std::uint32_t v : b.triangles)
    mesh.triangles.push_back(v + static_cast<std::uint32_t>(a.vertex_count()));
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Vertex& by) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] += by[i % 3];
  return mesh;
}

TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    std::swap(mesh.triangles[3 * t + 1], mesh.triangles[3 * t + 2]);
  return mesh;
}

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  mesh.triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  return mesh;
}

TriangleMesh box(const Vertex& low, const Vertex& high) {
  TriangleMesh mesh;
  for (int v = 0; v < 8; ++v)
    add_vertex(mesh,
               {v & 1 ? high[0] : low[0], v & 2 ? high[1] : low[1], v & 4 ? high[2] : low[2]});
  mesh.triangles = {0, 4, 6, 0, 6, 2,  // -x
                    1, 3, 7, 1, 7, 5,  // +x
                    0, 1, 5, 0, 5, 4,  // -y
                    2, 6, 7, 2, 7, 3,  // +y
                    0, 2, 3, 0, 3, 1,  // -z
                    4, 5, 7, 4, 7, 6};
  return mesh;
}

TriangleMesh sphere(float radius, int levels) {
  const float g = (1 + std::sqrt(5.0f)) / 2;
  TriangleMesh mesh;
  for (const Vertex& p : {Vertex{-1, g, 0},
                          {1, g, 0},
                          {-1, -g, 0},
                          {1, -g, 0},
                          {0, -1, g},
                          {0, 1, g},
                          {0, -1, -g},
                          {0, 1, -g},
                          {g, 0, -1},
                          {g, 0, 1},
                          {-g, 0, -1},
                          {-g, 0, 1}})
    add_vertex(mesh, p);
  mesh.triangles = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                    4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                    6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto split = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] = middle.try_emplace(std::minmax(a, b), 0u);
      if (is_new) {
        Vertex p;
        for (int i = 0; i < 3; ++i)
          p[i] = 0.5f * (mesh.vertices[3 * a + i] + mesh.vertices[3 * b + i]);
        entry->second = add_vertex(mesh, p);
      }
      return entry->second;
    };
    const std::vector<std::uint32_t> old = std::exchange(mesh.triangles, {});
    for (std::size_t t = 0; t < old.size(); t += 3) {
      const std::uint32_t a = old[t], b = old[t + 1], c = old[t + 2];
      const std::uint32_t ab = split(a, b), bc = split(b, c), ca = split(c, a);
      for (const auto& [i, j, k] : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
        add_triangle(mesh, i, j, k);
    }
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    float* p = mesh.vertices.data() + 3 * v;
    const float scale = radius / std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (int i = 0; i < 3; ++i) p[i] *= scale;
  }
  return mesh;
}

TriangleMesh torus(float large, float small, int n, int m) {
  TriangleMesh mesh;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m;
      const double r = large + small * std::cos(v);
      add_vertex(mesh, {static_cast<float>(r * std::cos(u)), static_cast<float>(r * std::sin(u)),
                        static_cast<float>(small * std::sin(v))});
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const auto at = [&](int a, int b) { return static_cast<std::uint32_t>(a % n * m + b % m); };
      add_triangle(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add_triangle(mesh, at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return mesh;
}

}  // namespace vasamesh::test

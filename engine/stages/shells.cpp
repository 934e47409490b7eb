#include "stages/shells.h"

#include <cmath>
#include <limits>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "stages/rays.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 64;  // shells a task takes

const float* vertex(const TriangleMesh& mesh, std::size_t v) {
  return mesh.vertices.data() + 3 * v;
}

/// Six times the volume of the tetrahedron from `origin` to a triangle.
double six_volumes(const TriangleMesh& mesh, std::size_t triangle, const float* origin) {
  double p[3][3];
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a)
      p[i][a] = double{vertex(mesh, mesh.triangles[3 * triangle + i])[a]} - origin[a];
  return p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
         p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
         p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
}

/// The vertex of largest x of each shell, the first among equals.
std::vector<std::uint32_t> farthest_vertices(const Backend& backend, const TriangleMesh& mesh,
                                             const Shells& shells) {
  std::vector<std::uint32_t> farthest(shells.shells.size());
  for (std::size_t s = 0; s < farthest.size(); ++s) farthest[s] = shells.shells[s].first_vertex;
  in_steps(backend, mesh.vertex_count(), [&](std::size_t v) {
    const std::uint32_t s = shells.shell_of[v];
    if (s != Shells::kNone && vertex(mesh, v)[0] > vertex(mesh, farthest[s])[0])
      farthest[s] = static_cast<std::uint32_t>(v);
  });
  return farthest;
}

}  // namespace

Shells find_shells(Backend& backend, const TriangleMesh& mesh,
                   const std::vector<std::uint8_t>& valid, const ManifoldCounts& manifold) {
  const std::vector<std::uint32_t> root = connect_vertices(backend, mesh, valid);
  Shells result;
  resize_in_steps(backend, mesh.vertex_count(), result.shell_of, Shells::kNone);
  in_steps(backend, mesh.triangle_count(), [&](std::size_t t) {
    if (!valid[t]) return;
    std::uint32_t& shell = result.shell_of[root[mesh.triangles[3 * t]]];
    if (shell == Shells::kNone) {
      shell = static_cast<std::uint32_t>(result.shells.size());
      result.shells.push_back({});
      result.shells.back().first_vertex = root[mesh.triangles[3 * t]];
    }
    Shell& s = result.shells[shell];
    ++s.triangles;
    const double volume = six_volumes(mesh, t, vertex(mesh, s.first_vertex)) / 6;
    if (std::isfinite(volume)) s.volume += volume;
  });
  in_steps(backend, mesh.vertex_count(), [&](std::size_t v) {
    const std::uint32_t shell = result.shell_of[v] = result.shell_of[root[v]];
    if (shell == Shells::kNone) return;
    ++result.shells[shell].vertices;
    result.shells[shell].edges += manifold.edges_up[v];
  });
  return result;
}

void find_nesting(Backend& backend, const TriangleMesh& mesh, const TriangleTree& tree,
                  Shells& shells) {
  if (shells.shells.size() < 2 || tree.empty()) return;
  const std::vector<std::uint32_t> farthest = farthest_vertices(backend, mesh, shells);
  const RayCaster rays(mesh, tree);
  for_each_index(backend, shells.shells.size(), kGrain, [&](std::size_t s) {
    bool odd = false;
    double nearest = std::numeric_limits<double>::infinity();
    rays.cast(vertex(mesh, farthest[s]), [&](const RayCrossing& crossing) {
      const std::uint32_t other =
          shells.shell_of[mesh.triangles[3 * std::size_t{crossing.triangle}]];
      if (other == s) return;
      odd ^= true;
      if (crossing.x >= nearest) return;
      nearest = crossing.x;
      shells.shells[s].next = other;
    });
    shells.shells[s].nested = odd;
  });
}

}  // namespace vasamesh

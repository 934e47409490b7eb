#include "stages/curvature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "stages/gap_loops.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kSide = 8;
constexpr double kTwoPi = 6.283185307179586;

using Cube = std::array<int, 3>;  // of the grid
using Sums = std::map<Cube, double>;

/// What is missing from 2 pi at each vertex.
std::vector<double> angle_defects(const TriangleMesh& mesh) {
  std::vector<double> defects(mesh.vertex_count(), kTwoPi);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = mesh.triangles[3 * t + i];
      const Vec3 p = vertex_at(mesh, v);
      const Vec3 a = vertex_at(mesh, mesh.triangles[3 * t + (i + 1) % 3]) - p;
      const Vec3 b = vertex_at(mesh, mesh.triangles[3 * t + (i + 2) % 3]) - p;
      defects[v] -= double{angle_of(dot(a, b), norm(cross(a, b)))};
    }
  return defects;
}

void add(const TriangleMesh& mesh, double sign, float shift, Sums& sums) {
  const std::vector<double> defects = angle_defects(mesh);
  for (std::uint32_t v = 0; v < defects.size(); ++v) {
    const Vec3 p = (1 / kSide) * vertex_at(mesh, v);
    const Cube cube = {static_cast<int>(std::floor(p.x + shift)),
                       static_cast<int>(std::floor(p.y + shift)),
                       static_cast<int>(std::floor(p.z + shift))};
    sums[cube] += sign * defects[v];
  }
}

}  // namespace

std::vector<Vec3> curvature_differences(const TriangleMesh& a, const TriangleMesh& b) {
  std::vector<Vec3> found;
  for (const float shift : {0.0f, 0.5f}) {
    Sums sums;
    add(a, 1, shift, sums);
    add(b, -1, shift, sums);
    for (const auto& [cube, sum] : sums)
      if (std::fabs(sum) > kTwoPi)
        found.push_back({kSide * (static_cast<float>(cube[0]) + 0.5f - shift),
                         kSide * (static_cast<float>(cube[1]) + 0.5f - shift),
                         kSide * (static_cast<float>(cube[2]) + 0.5f - shift)});
  }
  return found;
}

}  // namespace vasamesh

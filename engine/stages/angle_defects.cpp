#include "stages/angle_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "types/angles.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr float kCell = kAngleDefectCube / 2;
constexpr std::size_t kGrain = 8192;  // triangles a task takes

using Cell = std::array<int, 3>;  // of the grid
using Sums = std::map<Cell, double>;

Cell moved(const Cell& cell, int sign, int corner) {
  return {cell[0] + sign * (corner & 1), cell[1] + sign * (corner >> 1 & 1),
          cell[2] + sign * (corner >> 2)};
}

/// The angle at each corner of the triangles.
std::vector<float> corner_angles(Backend& backend, const TriangleMesh& mesh) {
  const std::size_t count = mesh.triangle_count();
  std::vector<float> angles(3 * count);
  for_each_index(backend, count, kGrain, [&](std::size_t t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p = vertex_at(mesh, mesh.triangles[3 * t + i]);
      const Vec3 a = vertex_at(mesh, mesh.triangles[3 * t + (i + 1) % 3]) - p;
      const Vec3 b = vertex_at(mesh, mesh.triangles[3 * t + (i + 2) % 3]) - p;
      angles[3 * t + i] = angle_of(dot(a, b), norm(cross(a, b)));
    }
  });
  return angles;
}

/// Adds what is missing from 2 pi at each vertex to the sum of its cell.
void add(Backend& backend, const TriangleMesh& mesh, double sign, Sums& sums) {
  const std::vector<float> angles = corner_angles(backend, mesh);
  auto missing = filled_in_steps(backend, mesh.vertex_count(), kTwoPi);
  in_steps(backend, angles.size(),
           [&](std::size_t c) { missing[mesh.triangles[c]] -= double{angles[c]}; });
  auto at = sums.end();
  in_steps(backend, missing.size(), [&](std::size_t v) {
    const Vec3 p = (1 / kCell) * vertex_at(mesh, v);
    const Cell cell = {static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                       static_cast<int>(std::floor(p.z))};
    if (at == sums.end() || at->first != cell) at = sums.try_emplace(cell, 0.0).first;
    at->second += sign * missing[v];
  });
}

struct Cube {
  double difference;
  Cell low;  ///< the first of its eight cells

  bool operator<(const Cube& other) const {
    return std::tie(other.difference, low) < std::tie(difference, other.low);
  }
  bool overlaps(const Cube& other) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(low[i] - other.low[i]) > 1) return false;
    return true;
  }
  Vec3 middle() const {
    return {kCell * static_cast<float>(low[0] + 1), kCell * static_cast<float>(low[1] + 1),
            kCell * static_cast<float>(low[2] + 1)};
  }
};

/// The cubes that have a cell with a sum, those with the largest differences first.
std::vector<Cube> cubes_of(const Sums& sums) {
  std::set<Cell> lows;
  for (const auto& [cell, sum] : sums)
    for (int corner = 0; corner < 8; ++corner) lows.insert(moved(cell, -1, corner));
  std::vector<Cube> cubes;
  for (const Cell& low : lows) {
    double difference = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const auto found = sums.find(moved(low, 1, corner));
      if (found != sums.end()) difference += found->second;
    }
    cubes.push_back({std::fabs(difference), low});
  }
  std::sort(cubes.begin(), cubes.end());
  return cubes;
}

}  // namespace

std::vector<Vec3> angle_defect_differences(Backend& backend, const TriangleMesh& a,
                                           const TriangleMesh& b) {
  Sums sums;
  add(backend, a, 1, sums);
  add(backend, b, -1, sums);
  const std::vector<Cube> cubes = cubes_of(sums);
  const bool any_handle = !cubes.empty() && cubes[0].difference > 1.5 * kTwoPi;
  const double least = any_handle ? 1.5 * kTwoPi : kTwoPi;
  std::vector<Cube> found;
  for (const Cube& cube : cubes) {
    if (!(cube.difference > least)) break;
    if (std::none_of(found.begin(), found.end(), [&](const Cube& c) { return c.overlaps(cube); }))
      found.push_back(cube);
  }
  std::vector<Vec3> middles;
  for (const Cube& cube : found) middles.push_back(cube.middle());
  return middles;
}

}  // namespace vasamesh

#include "stages/small_shells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "stages/disjoint_sets.h"

namespace vasamesh {

namespace {

constexpr double kLeastShare = 0.5;   // of the volume at first
constexpr double kLeastBulge = 0.06;  // volume over area^1.5 of an open one; half a ball: 0.13

/// Of the tetrahedron from `origin` over a triangle.
double six_volumes(const PatchMesh& mesh, const Vec3& origin,
                   const SmallShells::Corners& triangle) {
  const Vec3 a = mesh.points[triangle[0]].position - origin;
  return double{dot(a, cross(mesh.points[triangle[1]].position - origin,
                             mesh.points[triangle[2]].position - origin))};
}

/// The lowest vertex of the shell of each vertex.
std::vector<std::uint32_t> roots_of(const PatchMesh& mesh) {
  DisjointSets joined(mesh.vertex_count());
  for (std::uint32_t h = 0; h < mesh.half_edge_end(); ++h) {
    mesh.take_turn();
    if (mesh.is_edge(h)) joined.unite(mesh.origin(h), mesh.target(h));
  }
  return std::move(joined).roots();
}

}  // namespace

SmallShells::SmallShells(const PatchMesh& mesh)
    : shell_of_(mesh.vertex_count(), kNone), end_(mesh.half_edge_end()) {
  const std::vector<std::uint32_t> root = roots_of(mesh);
  std::vector<std::uint32_t> size(root.size(), 0);
  for (std::uint32_t h = 0; h < end_; h += 4)
    if (mesh.is_edge(h)) ++size[root[mesh.origin(h)]];
  std::vector<std::uint32_t> number(root.size(), kNone);
  std::vector<Shell> found;
  for (std::uint32_t h = 0; h < end_; h += 4) {
    if (!mesh.is_edge(h) || size[root[mesh.origin(h)]] > kMost) continue;
    std::uint32_t& shell = number[root[mesh.origin(h)]];
    if (shell == kNone) {
      shell = static_cast<std::uint32_t>(found.size());
      found.emplace_back();
    }
    found[shell].faces.push_back(h);
  }
  for (Shell& shell : found) {
    mesh.take_turn();
    if (!is_small(mesh, shell)) continue;
    for (const std::uint32_t h : shell.faces)
      for (const std::uint32_t v : mesh.corners(h))
        shell_of_[v] = static_cast<std::uint32_t>(shells_.size());
    shells_.push_back(std::move(shell));
  }
}

/// Whether a shell is closed or bulges. Sets its origin and volume.
bool SmallShells::is_small(const PatchMesh& mesh, Shell& shell) const {
  shell.origin = mesh.points[mesh.origin(shell.faces.front())].position;
  bool closed = true;
  double area = 0;
  for (const std::uint32_t h : shell.faces) {
    const Corners t = mesh.corners(h);
    const Vec3& a = mesh.points[t[0]].position;
    area +=
        0.5 * double{norm(cross(mesh.points[t[1]].position - a, mesh.points[t[2]].position - a))};
    for (const std::uint32_t v : t) {
      if (mesh.is_inner(v)) continue;
      closed = false;
      shell.origin = mesh.points[v].position;
    }
  }
  shell.volume = volume(mesh, shell);
  return closed ? shell.volume != 0
                : std::fabs(shell.volume) >= kLeastBulge * area * std::sqrt(area);
}

void SmallShells::take_up(const PatchMesh& mesh, std::uint32_t h) {
  const std::uint32_t first = h & ~3u;
  if (first < end_) return;
  end_ = first + 4;
  const Corners corners = mesh.corners(first);
  const auto known = [&](std::uint32_t v) { return v < shell_of_.size(); };
  const auto old = std::find_if(corners.begin(), corners.end(), known);
  const std::uint32_t shell = shell_of_[*old];
  for (const std::uint32_t v : corners) {
    if (known(v)) continue;
    shell_of_.resize(v + 1, kNone);
    shell_of_[v] = shell;
  }
  if (shell != kNone) shells_[shell].faces.push_back(first);
}

double SmallShells::volume(const PatchMesh& mesh, const Shell& shell) const {
  double sum = 0;
  for (const std::uint32_t h : shell.faces)
    if (mesh.is_edge(h)) sum += six_volumes(mesh, shell.origin, mesh.corners(h));
  return sum / 6;
}

bool SmallShells::keep_volume(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                              std::span<const Corners> made) const {
  const std::uint32_t number = shell_of_[made[0][0]];
  if (number == kNone) return true;
  const Shell& shell = shells_[number];
  double change = 0;
  for (const std::uint32_t h : gone) change -= six_volumes(mesh, shell.origin, mesh.corners(h));
  for (const Corners& triangle : made) change += six_volumes(mesh, shell.origin, triangle);
  return (volume(mesh, shell) + change / 6) / shell.volume >= kLeastShare;
}

}  // namespace vasamesh

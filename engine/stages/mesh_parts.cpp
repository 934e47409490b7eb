#include "stages/mesh_parts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

using Position = std::array<float, 3>;

Position position_of(const TriangleMesh& mesh, std::uint32_t v) {
  const Vec3 p = vertex_at(mesh, v);
  return {p.x, p.y, p.z};
}

/// Appends a corner to a part, with its vertex when that is new there.
void add_corner(const TriangleMesh& mesh, std::uint32_t v, std::vector<std::uint32_t>& renamed,
                TriangleMesh& part) {
  if (renamed[v] == kNone) {
    renamed[v] = static_cast<std::uint32_t>(part.vertex_count());
    const float* p = mesh.vertices.data() + 3 * std::size_t{v};
    part.vertices.insert(part.vertices.end(), p, p + 3);
  }
  part.triangles.push_back(renamed[v]);
}

}  // namespace

TriangleMesh part_of(const TriangleMesh& mesh, const std::vector<std::uint8_t>& chosen) {
  TriangleMesh part;
  std::vector<std::uint32_t> renamed(mesh.vertex_count(), kNone);
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    if (chosen[c / 3]) add_corner(mesh, mesh.triangles[c], renamed, part);
  return part;
}

std::vector<TriangleMesh> parts_of(const TriangleMesh& mesh, const std::vector<std::uint8_t>& part,
                                   std::size_t count) {
  std::vector<TriangleMesh> parts(count);
  std::vector<std::uint32_t> renamed(mesh.vertex_count(), kNone);
  for (std::size_t c = 0; c < mesh.triangles.size(); ++c)
    if (const std::size_t p = part[c / 3]; p > 0)
      add_corner(mesh, mesh.triangles[c], renamed, parts[p - 1]);
  return parts;
}

TriangleMesh joined(TriangleMesh first, const TriangleMesh& second) {
  const auto shift = static_cast<std::uint32_t>(first.vertex_count());
  first.vertices.insert(first.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (const std::uint32_t v : second.triangles) first.triangles.push_back(v + shift);
  return first;
}

TriangleMesh with_part(const TriangleMesh& mesh, const std::vector<std::uint8_t>& chosen,
                       const TriangleMesh& part) {
  enum : std::uint8_t { kOutside = 1, kInside = 2 };
  std::vector<std::uint8_t> side(mesh.vertex_count(), 0);
  std::vector<std::uint8_t> others(chosen.size());
  for (std::size_t t = 0; t < chosen.size(); ++t) {
    others[t] = !chosen[t];
    for (std::size_t i = 0; i < 3; ++i)
      side[mesh.triangles[3 * t + i]] |= chosen[t] ? kInside : kOutside;
  }
  TriangleMesh result = part_of(mesh, others);
  std::vector<std::uint8_t> shared;
  for (std::size_t t = 0; t < chosen.size(); ++t)
    for (std::size_t i = 0; i < 3 && others[t]; ++i)
      shared.push_back(side[mesh.triangles[3 * t + i]] == (kInside | kOutside));
  std::vector<std::pair<Position, std::uint32_t>> border;
  for (std::size_t c = 0; c < shared.size(); ++c)
    if (shared[c])
      border.emplace_back(position_of(result, result.triangles[c]), result.triangles[c]);
  std::sort(border.begin(), border.end());

  std::vector<std::uint32_t> renamed(part.vertex_count());
  for (std::uint32_t v = 0; v < renamed.size(); ++v) {
    const Position p = position_of(part, v);
    const auto found = std::lower_bound(border.begin(), border.end(), std::pair{p, 0u});
    if (found != border.end() && found->first == p) {
      renamed[v] = found->second;
      continue;
    }
    renamed[v] = static_cast<std::uint32_t>(result.vertex_count());
    result.vertices.insert(result.vertices.end(), p.begin(), p.end());
  }
  for (const std::uint32_t v : part.triangles) result.triangles.push_back(renamed[v]);
  return result;
}

}  // namespace vasamesh

#include "stages/mesh_parts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/lower_to.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::size_t kGrain = 16384;  // corners or triangles a task takes

/// How many indices that are counted (is_counted(i)) come before each task's; at the end, how many
/// there are.
template <class IsCounted>
std::vector<std::size_t> starts_of(Backend& backend, std::size_t count,
                                   const IsCounted& is_counted) {
  auto starts = map_ranges(backend, count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += is_counted(i);
    return sum;
  });
  starts.push_back(0);
  std::exclusive_scan(starts.begin(), starts.end(), starts.begin(), std::size_t{0});
  return starts;
}

/// The corners of the chosen triangles, in order.
std::vector<std::uint32_t> corners_of(Backend& backend, const TriangleMesh& mesh,
                                      const std::vector<std::uint8_t>& chosen) {
  const std::size_t count = mesh.triangle_count();
  const auto starts = starts_of(backend, count, [&](std::size_t t) { return chosen[t] != 0; });
  auto corners = filled_in_steps<std::uint32_t>(backend, 3 * starts.back());
  for_each_range(backend, count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::uint32_t* to = corners.data() + 3 * starts[begin / kGrain];
    for (std::size_t t = begin; t < end; ++t)
      if (chosen[t]) to = std::copy_n(&mesh.triangles[3 * t], 3, to);
  });
  return corners;
}

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

std::vector<std::uint32_t> rename_in_order(Backend& backend, std::size_t vertices,
                                           std::vector<std::uint32_t>& corners) {
  const std::size_t count = corners.size();
  auto first = filled_in_steps(backend, vertices, kNone);  // corner
  for_each_index(backend, count, kGrain, [&](std::size_t c) {
    lower_to(first[corners[c]], static_cast<std::uint32_t>(c));
  });
  const auto starts =
      starts_of(backend, count, [&](std::size_t c) { return first[corners[c]] == c; });
  auto old_names = filled_in_steps<std::uint32_t>(backend, starts.back());
  auto name = filled_in_steps<std::uint32_t>(backend, vertices);
  for_each_range(backend, count, kGrain, [&](std::size_t begin, std::size_t end) {
    auto next = static_cast<std::uint32_t>(starts[begin / kGrain]);
    for (std::size_t c = begin; c < end; ++c) {
      if (first[corners[c]] != c) continue;
      old_names[next] = corners[c];
      name[corners[c]] = next++;
    }
  });
  for_each_index(backend, count, kGrain, [&](std::size_t c) { corners[c] = name[corners[c]]; });
  return old_names;
}

TriangleMesh part_of(Backend& backend, const TriangleMesh& mesh,
                     const std::vector<std::uint8_t>& chosen) {
  TriangleMesh part;
  part.triangles = corners_of(backend, mesh, chosen);
  const std::vector<std::uint32_t> vertices =
      rename_in_order(backend, mesh.vertex_count(), part.triangles);
  resize_in_steps(backend, 3 * vertices.size(), part.vertices);
  for_each_index(backend, vertices.size(), kGrain, [&](std::size_t v) {
    std::copy_n(&mesh.vertices[3 * std::size_t{vertices[v]}], 3, &part.vertices[3 * v]);
  });
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

TriangleMesh with_part(Backend& backend, const TriangleMesh& mesh,
                       const std::vector<std::uint8_t>& chosen, const TriangleMesh& part) {
  enum : std::uint8_t { kOutside = 1, kInside = 2 };
  std::vector<std::uint8_t> side(mesh.vertex_count(), 0);
  std::vector<std::uint8_t> others(chosen.size());
  for (std::size_t t = 0; t < chosen.size(); ++t) {
    others[t] = !chosen[t];
    for (std::size_t i = 0; i < 3; ++i)
      side[mesh.triangles[3 * t + i]] |= chosen[t] ? kInside : kOutside;
  }
  TriangleMesh result = part_of(backend, mesh, others);
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

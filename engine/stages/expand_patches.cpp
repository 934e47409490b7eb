#include "stages/expand_patches.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/adjacency.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kAgree = 0.3f;  // least cosine of the function's normal and the triangles' own
constexpr std::size_t kGrain = 1024;

/// The sum of the area vectors of the triangles at a vertex, as a unit vector.
Vec3 triangles_normal(const TriangleMesh& mesh, const VertexCorners& corners, std::size_t v) {
  Vec3 sum;
  for (std::uint32_t i = corners.first[v]; i < corners.first[v + 1]; ++i) {
    const std::uint32_t* t = &mesh.triangles[corners.corner[i] / 3 * 3];
    const Vec3 a = vertex_at(mesh, t[0]);
    sum = sum + cross(vertex_at(mesh, t[1]) - a, vertex_at(mesh, t[2]) - a);
  }
  return normalised(sum);
}

/// Whether a triangle at vertex `from` has the edge from -> to.
bool has_edge(const TriangleMesh& mesh, const VertexCorners& corners, std::uint32_t from,
              std::uint32_t to) {
  for (std::uint32_t i = corners.first[from]; i < corners.first[from + 1]; ++i) {
    const std::uint32_t c = corners.corner[i];
    if (mesh.triangles[c / 3 * 3 + (c + 1) % 3] == to) return true;
  }
  return false;
}

/// Links the corners that end at one vertex to those that begin there. Where several do, the patch
/// touches itself, and each takes the nearest counter-clockwise: the angle between them is open.
void link_at_vertex(Front& front, std::span<const std::uint32_t> ending,
                    std::span<const std::uint32_t> ends, std::span<const std::uint32_t> beginning) {
  std::vector<std::uint8_t> used(beginning.size(), 0);
  for (const std::uint32_t from : ending) {
    std::size_t best = beginning.size();
    float least = 0;
    for (std::size_t i = 0; i < beginning.size(); ++i) {
      if (used[i]) continue;
      const std::uint32_t v = front.vertex[beginning[i]];
      const float angle = angle_between(front.position[v], front.normal[v], front.at(from),
                                        front.position[ends[beginning[i]]]);
      if (best < beginning.size() && !(angle < least)) continue;
      best = i;
      least = angle;
    }
    used[best] = 1;
    front.link(from, beginning[best]);
  }
}

/// Corners of the open boundary, in the order of the triangles' edges, linked in loops.
void take_boundary(const TriangleMesh& patches, const VertexCorners& corners, Front& front) {
  std::vector<std::uint32_t> ends;  // a corner: the vertex that its edge leads to
  for (std::size_t c = 0; c < patches.triangles.size(); ++c) {
    const std::uint32_t from = patches.triangles[c];
    const std::uint32_t to = patches.triangles[c / 3 * 3 + (c + 1) % 3];
    if (has_edge(patches, corners, to, from)) continue;
    front.add_corner(from);
    ends.push_back(to);
  }
  std::vector<std::uint32_t> by_start(ends.size()), by_end(ends.size());
  for (std::uint32_t c = 0; c < ends.size(); ++c) by_start[c] = by_end[c] = c;
  std::stable_sort(by_start.begin(), by_start.end(), [&](std::uint32_t a, std::uint32_t b) {
    return front.vertex[a] < front.vertex[b];
  });
  std::stable_sort(by_end.begin(), by_end.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return ends[a] < ends[b]; });
  for (std::size_t i = 0; i < ends.size();) {
    std::size_t end = i + 1;
    while (end < ends.size() && ends[by_end[end]] == ends[by_end[i]]) ++end;
    link_at_vertex(front, {&by_end[i], end - i}, ends, {&by_start[i], end - i});
    i = end;
  }
}

}  // namespace

Front take_patches(Backend& backend, const FieldView& field, const SizeView& sizes,
                   const TriangleMesh& patches) {
  Front front;
  const std::size_t count = patches.vertex_count();
  front.resize_vertices(count);
  front.triangles = patches.triangles;
  const VertexCorners corners = vertex_corners(patches);
  backend.run((count + kGrain - 1) / kGrain, [&](std::size_t task) {
    const std::size_t end = std::min((task + 1) * kGrain, count);
    for (std::size_t v = task * kGrain; v < end; ++v) {
      front.position[v] = vertex_at(patches, v);
      front.size[v] = size_at(sizes, front.position[v]);
      const Vec3 own = triangles_normal(patches, corners, v);
      const Vec3 smooth = -normalised(sample_field(field, front.position[v]).gradient);
      front.normal[v] = dot(own, smooth) > kAgree ? smooth : own;
    }
  });
  take_boundary(patches, corners, front);
  return front;
}

FrontResult give_result(const Front& front) {
  FrontResult result;
  result.mesh.vertices.reserve(3 * front.position.size());
  for (const Vec3& p : front.position)
    result.mesh.vertices.insert(result.mesh.vertices.end(), {p.x, p.y, p.z});
  result.mesh.triangles = front.triangles;
  std::vector<std::uint8_t> seen(front.vertex.size(), 0);
  std::vector<std::uint32_t> loop;
  for (const std::uint32_t first : front.alive) {
    if (seen[first]) continue;
    loop.clear();
    for (std::uint32_t c = first; !seen[c]; c = front.previous[c]) {
      seen[c] = 1;
      loop.push_back(front.vertex[c]);
    }
    result.loops.add(loop);
  }
  return result;
}

}  // namespace vasamesh

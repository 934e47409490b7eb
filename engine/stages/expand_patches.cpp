#include "stages/expand_patches.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "backend/ranges.h"
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
void link_at_vertex(Front& front, const FrontView& view, std::span<const std::uint32_t> ending,
                    std::span<const std::uint32_t> ends, std::span<const std::uint32_t> beginning) {
  std::vector<std::uint8_t> used(beginning.size(), 0);
  for (const std::uint32_t from : ending) {
    std::size_t best = beginning.size();
    float least = 0;
    for (std::size_t i = 0; i < beginning.size(); ++i) {
      if (used[i]) continue;
      const FrontVertex& v = view.vertex_of(beginning[i]);
      const float angle = angle_between(v.position, v.normal, view.position_of(from),
                                        view.vertices[ends[beginning[i]]].position);
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
  const FrontView view = front.view();
  std::vector<std::uint32_t> by_start(ends.size()), by_end(ends.size());
  for (std::uint32_t c = 0; c < ends.size(); ++c) by_start[c] = by_end[c] = c;
  std::stable_sort(by_start.begin(), by_start.end(), [&](std::uint32_t a, std::uint32_t b) {
    return view.corners[a].vertex < view.corners[b].vertex;
  });
  std::stable_sort(by_end.begin(), by_end.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return ends[a] < ends[b]; });
  for (std::size_t i = 0; i < ends.size();) {
    std::size_t end = i + 1;
    while (end < ends.size() && ends[by_end[end]] == ends[by_end[i]]) ++end;
    link_at_vertex(front, view, {&by_end[i], end - i}, ends, {&by_start[i], end - i});
    i = end;
  }
}

}  // namespace

Front take_patches(Backend& backend, const FieldView& field, const SizeView& sizes,
                   const TriangleMesh& patches) {
  Front front(backend, field);
  const std::size_t count = patches.vertex_count();
  front.reserve(count, patches.triangle_count(), 0);
  front.bring_to_host();
  std::vector<Vec3> normals(count);
  const VertexCorners corners = vertex_corners(backend, patches);
  for_each_index(backend, count, kGrain, [&](std::size_t v) {
    const Vec3 own = triangles_normal(patches, corners, v);
    const Vec3 smooth = -normalised(sample_field(field, vertex_at(patches, v)).gradient);
    normals[v] = dot(own, smooth) > kAgree ? smooth : own;
  });
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3 p = vertex_at(patches, v);
    front.add_vertex(p, normals[v], size_at(sizes, p));
  }
  for (std::size_t t = 0; t < patches.triangles.size(); t += 3)
    front.add_triangle(patches.triangles[t], patches.triangles[t + 1], patches.triangles[t + 2]);
  take_boundary(patches, corners, front);
  return front;
}

FrontResult give_result(Front& front) {
  FrontResult result;
  front.bring_to_host();
  const FrontView view = front.view();
  const FrontCounts& counts = front.counts();
  result.mesh.vertices.reserve(3 * std::size_t{counts.vertices});
  for (std::uint32_t v = 0; v < counts.vertices; ++v) {
    const Vec3& p = view.vertices[v].position;
    result.mesh.vertices.insert(result.mesh.vertices.end(), {p.x, p.y, p.z});
  }
  const std::uint32_t* triangles = view.triangles.data();
  result.mesh.triangles.assign(triangles, triangles + 3 * std::size_t{counts.triangles});
  std::vector<std::uint8_t> seen(counts.corners, 0);
  std::vector<std::uint32_t> loop;
  for (std::uint32_t i = 0; i < counts.listed; ++i) {
    loop.clear();
    for (std::uint32_t c = view.listed[i]; !seen[c]; c = view.corners[c].previous) {
      seen[c] = 1;
      loop.push_back(view.corners[c].vertex);
    }
    if (!loop.empty()) result.loops.add(loop);
  }
  return result;
}

}  // namespace vasamesh

#include "stages/patch_blocks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/mesh_parts.h"
#include "types/box.h"
#include "types/mesh_vertex.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16384;  // triangles or vertices a task takes
constexpr std::uint32_t kNone = PatchMesh::kNone;

/// The triangles of block b are order[first[b]] .. order[first[b + 1] - 1].
struct Division {
  std::vector<std::uint32_t> first, order;
  std::size_t count() const { return first.size() - 1; }
};

/// Cells of a grid round all vertices.
class Cells {
 public:
  Cells(const Backend& backend, const std::vector<SurfacePoint>& points, const BlockGrid& grid)
      : inverse_(1 / grid.side) {
    Box box;
    in_steps(backend, points.size(), [&](std::size_t v) { box.take_in(points[v].position); });
    const float back = (1 - grid.shift) * grid.side;
    origin_ = box.low - Vec3{back, back, back};
    const Vec3 extent = inverse_ * (box.high - origin_);
    size_ = {static_cast<std::size_t>(extent.x) + 1, static_cast<std::size_t>(extent.y) + 1,
             static_cast<std::size_t>(extent.z) + 1};
  }

  std::size_t count() const { return size_[0] * size_[1] * size_[2]; }

  std::uint32_t at(const Vec3& p) const {
    const Vec3 q = inverse_ * (p - origin_);
    const std::size_t x = std::min(static_cast<std::size_t>(std::max(q.x, 0.0f)), size_[0] - 1);
    const std::size_t y = std::min(static_cast<std::size_t>(std::max(q.y, 0.0f)), size_[1] - 1);
    const std::size_t z = std::min(static_cast<std::size_t>(std::max(q.z, 0.0f)), size_[2] - 1);
    return static_cast<std::uint32_t>(x + size_[0] * (y + size_[1] * z));
  }

 private:
  float inverse_;
  Vec3 origin_;
  std::array<std::size_t, 3> size_{1, 1, 1};
};

/// Triangles by the cells of their first corners, in the order of cells, then of triangles.
Division divide(Backend& backend, const BlockGrid& grid, const WorkingSurface& surface) {
  const std::size_t triangles = surface.triangles.size() / 3;
  const Cells cells(backend, surface.points, grid);
  auto cell = filled_in_steps<std::uint32_t>(backend, triangles);
  for_each_index(backend, triangles, kGrain, [&](std::size_t t) {
    cell[t] = cells.at(surface.points[surface.triangles[3 * t]].position);
  });
  std::vector<std::uint32_t> block(cells.count(), 0);
  in_steps(backend, triangles, [&](std::size_t t) { ++block[cell[t]]; });
  Division division;
  division.first.push_back(0);
  for (std::uint32_t& count : block) {
    if (count == 0) continue;
    const std::uint32_t start = division.first.back();
    division.first.push_back(start + count);
    count = start;
  }
  resize_in_steps(backend, triangles, division.order);
  in_steps(backend, triangles, [&](std::size_t t) {
    division.order[block[cell[t]]++] = static_cast<std::uint32_t>(t);
  });
  return division;
}

/// Global vertices by the order in which they first come: an open-addressed table.
class VertexTable {
 public:
  explicit VertexTable(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), kNone) {}

  std::uint32_t insert(std::uint32_t vertex) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = vertex * 0x9e3779b1u & mask;; i = (i + 1) & mask) {
      if (slots_[i] == kNone) {
        slots_[i] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(vertex);
      }
      if (vertices[slots_[i]] == vertex) return slots_[i];
    }
  }

  std::vector<std::uint32_t> vertices;

 private:
  std::vector<std::uint32_t> slots_;
};

/// What a task leaves: corners below `old_count` are vertices of the surface, the others its own.
struct Part {
  std::vector<std::uint32_t> corners;
  std::vector<SurfacePoint> added;
};

/// Takes a block out of the surface. \param degree  triangles at each vertex.
SurfaceBlocks::Taken take_out(const Backend& backend, const WorkingSurface& surface,
                              const std::vector<std::uint32_t>& degree, const Division& division,
                              std::size_t b) {
  const std::uint32_t first = division.first[b], end = division.first[b + 1];
  VertexTable table(2 * (end - first));
  std::vector<std::uint32_t> corners, local_degree;
  corners.reserve(3 * (end - first));
  for (std::uint32_t i = first; i < end; ++i)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v =
          table.insert(surface.triangles[3 * std::size_t{division.order[i]} + k]);
      if (v == local_degree.size()) local_degree.push_back(0);
      ++local_degree[v];
      corners.push_back(v);
    }
  SurfaceBlocks::Taken taken;
  taken.source = std::move(table.vertices);
  std::vector<SurfacePoint> points(taken.source.size());
  std::vector<std::uint8_t> whole(taken.source.size());
  for (std::size_t v = 0; v < taken.source.size(); ++v) {
    const std::uint32_t from = taken.source[v];
    points[v] = surface.points[from];
    whole[v] = local_degree[v] == degree[from] && (surface.fixed.empty() || !surface.fixed[from]);
  }
  backend.checkpoint();
  taken.mesh.build(std::move(points), corners, std::move(whole));
  taken.mesh.set_backend(&backend);
  if (surface.keeps_border) taken.mesh.hold_border();
  return taken;
}

/// Writes a block's vertices back.
Part put_back(const SurfaceBlocks::Taken& taken, WorkingSurface& surface) {
  const PatchMesh& mesh = taken.mesh;
  const auto old_count = static_cast<std::uint32_t>(surface.points.size());
  Part part;
  std::vector<std::uint32_t> name(mesh.vertex_count(), kNone);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.is_there(v)) continue;
    if (v < taken.source.size()) {
      name[v] = taken.source[v];
      if (mesh.is_whole(v)) surface.points[name[v]] = mesh.points[v];
    } else {
      name[v] = old_count + static_cast<std::uint32_t>(part.added.size());
      part.added.push_back(mesh.points[v]);
    }
  }
  for (std::uint32_t h = 0; h < mesh.half_edge_end(); ++h)
    if (mesh.is_edge(h)) part.corners.push_back(name[mesh.origin(h)]);
  return part;
}

/// Triangles at each vertex.
std::vector<std::uint32_t> degrees(const Backend& backend, const WorkingSurface& surface) {
  auto degree = filled_in_steps<std::uint32_t>(backend, surface.points.size());
  for (const auto* triangles : {&surface.triangles, &surface.resting})
    in_steps(backend, triangles->size(), [&](std::size_t c) { ++degree[(*triangles)[c]]; });
  return degree;
}

/// Puts the parts one after the other.
void join_parts(Backend& backend, const std::vector<Part>& parts, WorkingSurface& surface) {
  const std::size_t old_count = surface.points.size();
  std::vector<std::size_t> corner_start(parts.size() + 1, 0), added_start(parts.size() + 1, 0);
  for (std::size_t b = 0; b < parts.size(); ++b) {
    corner_start[b + 1] = corner_start[b] + parts[b].corners.size();
    added_start[b + 1] = added_start[b] + parts[b].added.size();
  }
  if (corner_start.back() > 0xffffffffu)
    throw Error(ErrorCode::refused, "the surface has more than 2^32 corners: ask for longer edges");
  resize_in_steps(backend, old_count + added_start.back(), surface.points);
  if (!surface.fixed.empty()) surface.fixed.resize(surface.points.size(), 0);
  resize_in_steps(backend, corner_start.back(), surface.triangles);
  backend.run(parts.size(), [&](std::size_t b) {
    const auto shift = static_cast<std::uint32_t>(added_start[b]);
    std::uint32_t* to = surface.triangles.data() + corner_start[b];
    for (std::uint32_t v : parts[b].corners) *to++ = v < old_count ? v : v + shift;
    std::copy(parts[b].added.begin(), parts[b].added.end(),
              surface.points.begin() + static_cast<std::ptrdiff_t>(old_count + added_start[b]));
  });
}

}  // namespace

void for_each_block(Backend& backend, const BlockGrid& grid, WorkingSurface& surface,
                    const std::function<void(PatchMesh&)>& work) {
  if (surface.triangles.empty()) return;
  const std::vector<std::uint32_t> degree = degrees(backend, surface);
  const Division division = divide(backend, grid, surface);
  std::vector<Part> parts(division.count());
  backend.run(division.count(), [&](std::size_t b) {
    SurfaceBlocks::Taken taken = take_out(backend, surface, degree, division, b);
    work(taken.mesh);
    parts[b] = put_back(taken, surface);
  });
  join_parts(backend, parts, surface);
}

SurfaceBlocks::SurfaceBlocks(Backend& backend, const BlockGrid& grid, WorkingSurface& surface)
    : backend_(backend), surface_(surface) {
  if (surface.triangles.empty()) return;
  const std::vector<std::uint32_t> degree = degrees(backend, surface);
  const Division division = divide(backend, grid, surface);
  taken_.resize(division.count());
  backend.run(division.count(),
              [&](std::size_t b) { taken_[b] = take_out(backend, surface, degree, division, b); });
}

std::vector<PatchMesh*> SurfaceBlocks::parts() {
  std::vector<PatchMesh*> parts;
  for (Taken& taken : taken_) parts.push_back(&taken.mesh);
  return parts;
}

void SurfaceBlocks::join() {
  if (taken_.empty()) return;
  std::vector<Part> parts(taken_.size());
  backend_.run(parts.size(), [&](std::size_t b) { parts[b] = put_back(taken_[b], surface_); });
  join_parts(backend_, parts, surface_);
}

void for_each_part(Backend& backend, std::span<PatchMesh* const> parts,
                   const std::function<void(PatchMesh&)>& work) {
  backend.run(parts.size(), [&](std::size_t p) { work(*parts[p]); });
}

namespace {

/// Sums of the triangles' normals, by area, for the points that do not rest.
void set_mesh_normals(const Backend& backend, const TriangleMesh& mesh,
                      const std::vector<std::uint8_t>& rests, WorkingSurface& surface) {
  in_steps(backend, mesh.triangle_count(), [&](std::size_t t) {
    const std::uint32_t* v = &mesh.triangles[3 * t];
    if (rests[v[0]] && rests[v[1]] && rests[v[2]]) return;
    SurfacePoint* corner[3];
    for (int i = 0; i < 3; ++i) corner[i] = &surface.points[v[i]];
    const Vec3 normal =
        cross(corner[1]->position - corner[0]->position, corner[2]->position - corner[0]->position);
    for (SurfacePoint* p : corner) p->normal = p->normal + normal;
  });
}

/// Takes the triangles without a vertex near the places out. \return a byte a point: whether it has
/// no other triangles.
std::vector<std::uint8_t> put_to_rest(Backend& backend, const Places& places,
                                      WorkingSurface& surface) {
  const std::size_t count = surface.points.size();
  std::vector<std::uint8_t> near(count), rests(count, 1);
  for_each_index(backend, count, kGrain, [&](std::size_t v) {
    near[v] = places.hold(surface.points[v].position, Places::kMargin);
  });
  std::vector<std::uint32_t> active;
  in_steps(backend, surface.triangles.size() / 3, [&](std::size_t t) {
    const std::uint32_t* v = &surface.triangles[3 * t];
    const bool wanted = near[v[0]] || near[v[1]] || near[v[2]];
    std::vector<std::uint32_t>& to = wanted ? active : surface.resting;
    to.insert(to.end(), v, v + 3);
    if (wanted) rests[v[0]] = rests[v[1]] = rests[v[2]] = 0;
  });
  surface.triangles = std::move(active);
  return rests;
}

}  // namespace

WorkingSurface make_working_surface(Backend& backend, const RemeshGoal& goal,
                                    const TriangleMesh& mesh) {
  WorkingSurface surface;
  append_in_steps<std::uint32_t>(backend, mesh.triangles, surface.triangles);
  resize_in_steps(backend, mesh.vertex_count(), surface.points);
  const auto for_each_point = [&](const auto& visit) {
    for_each_index(backend, surface.points.size(), kGrain,
                   [&](std::size_t v) { visit(v, surface.points[v]); });
  };
  for_each_point([&](std::size_t v, SurfacePoint& p) { p.position = vertex_at(mesh, v); });
  std::vector<std::uint8_t> rests(mesh.vertex_count(), 0);
  if (goal.local) rests = put_to_rest(backend, *goal.places, surface);
  surface.keeps_border = goal.local;
  set_mesh_normals(backend, mesh, rests, surface);
  for_each_point([&](std::size_t v, SurfacePoint& p) {
    if (rests[v]) return;
    p.normal = normalised(p.normal);
    p.size = goal.size_at(p.position);
    take_normal(goal.field, p);
  });
  return surface;
}

void fix_places(const Backend& backend, const RemeshGoal& goal, WorkingSurface& surface) {
  if (!goal.places || !goal.places->any_fixed()) return;
  surface.fixed.resize(surface.points.size());
  in_steps(backend, surface.fixed.size(), [&](std::size_t v) {
    surface.fixed[v] = goal.size_at(surface.points[v].position) == 0;
  });
}

TriangleMesh make_mesh(Backend& backend, const WorkingSurface& surface) {
  TriangleMesh mesh;
  append_in_steps<std::uint32_t>(backend, surface.triangles, mesh.triangles);
  append_in_steps<std::uint32_t>(backend, surface.resting, mesh.triangles);
  const std::vector<std::uint32_t> vertices =
      rename_in_order(backend, surface.points.size(), mesh.triangles);
  resize_in_steps(backend, 3 * vertices.size(), mesh.vertices);
  for_each_index(backend, vertices.size(), kGrain, [&](std::size_t v) {
    const Vec3& p = surface.points[vertices[v]].position;
    const std::array<float, 3> position = {p.x, p.y, p.z};
    std::copy_n(position.begin(), 3, &mesh.vertices[3 * v]);
  });
  return mesh;
}

}  // namespace vasamesh

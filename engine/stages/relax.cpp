#include "stages/relax.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "stages/fan_moves.h"
#include "stages/patch_blocks.h"
#include "stages/patch_clearance.h"
#include "stages/patch_crowding.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

/// Adds the ring of a whole vertex (FanView).
void add_ring(const PatchMesh& mesh, std::uint32_t v, std::vector<std::uint32_t>& ring) {
  std::uint32_t last = v;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    ring.push_back(mesh.target(h));
    last = mesh.apex(h);
  });
  ring.push_back(last);
}

/// The vertices of a part that no pass of the field moves.
std::vector<std::uint32_t> vertices_off_field(const PatchMesh& mesh, bool inner_only) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.is_there(v) && !mesh.points[v].on_field &&
        (inner_only ? mesh.is_inner(v) : mesh.is_whole(v)))
      vertices.push_back(v);
  return vertices;
}

/// Where the field was of no use: onto the surface if it is of use by now, else in the mesh's own
/// tangent plane; and only if no triangles come to meet.
void smooth_off_field(PatchMesh& mesh, const RemeshGoal& goal) {
  const std::vector<std::uint32_t> vertices = vertices_off_field(mesh, false);
  if (vertices.empty()) return;
  Clearance clearance(mesh);
  std::vector<std::uint32_t> ring;
  for (std::uint32_t v : vertices) {
    mesh.take_turn();
    mesh.points[v].normal = fan_normal(mesh, v);
    SurfacePoint moved = mesh.points[v];
    const float limit = std::min(kSquaredSine25, facing_fan_quality(mesh, v));
    if (put_onto_surface(goal, kSmoothingReach, moved) && may_move(mesh, v, moved, limit) &&
        clearance.move_if_clear(mesh, v, moved))
      continue;
    ring.clear();
    add_ring(mesh, v, ring);
    moved = mesh.points[v];
    moved.position = moved.position + smoothing_step(moved, {mesh.points.data(), ring});
    if (may_move(mesh, v, moved, limit)) clearance.move_if_clear(mesh, v, moved);
  }
}

/// Across the vertices' normals, where no triangles come to meet.
void equalise_carefully(PatchMesh& mesh, const RemeshGoal& goal,
                        std::span<const std::uint32_t> vertices, int passes, Clearance& clearance) {
  std::vector<std::uint32_t> ring;
  SurfacePoint moved;
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t v : vertices) {
      mesh.take_turn();
      ring.clear();
      add_ring(mesh, v, ring);
      if (find_more_equal(goal, {mesh.points.data(), ring}, mesh.points[v], false, moved))
        clearance.move_if_clear(mesh, v, moved);
    }
}

void equalise_off_field(PatchMesh& mesh, const RemeshGoal& goal, int passes) {
  const std::vector<std::uint32_t> vertices = vertices_off_field(mesh, true);
  if (vertices.empty()) return;
  Clearance clearance(mesh);
  equalise_carefully(mesh, goal, vertices, passes, clearance);
}

// Of moves along normals: voxel lengths that are worth one, and the most, of the size.
constexpr float kLeastMove = 0.02f, kMostMove = 0.2f;

/// Gives the vertices off the field its normals, but not those that relaxation has moved.
void take_normals(PatchMesh& mesh, const FieldView& field) {
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.take_turn();
    if (mesh.is_there(v) && mesh.is_inner(v) && !mesh.points[v].on_field &&
        mesh.points[v].drift == 0)
      take_normal(field, mesh.points[v]);
  }
}

/// Whether v may go along its normal; `moved` is that place.
bool find_fit(const PatchMesh& mesh, std::uint32_t v, float move, SurfacePoint& moved) {
  moved = mesh.points[v];
  const float most = kMostMove * moved.size;
  move = std::clamp(move, -most, most);
  if (!(move * move >= kLeastMove * kLeastMove)) return false;
  moved.position = moved.position + move * moved.normal;
  return may_move(mesh, v, moved, std::min(kSquaredSine25, facing_fan_quality(mesh, v)));
}

PlaceView places_of(const RemeshGoal& goal) {
  return goal.places ? goal.places->view() : PlaceView{};
}

bool is_inner_on_field(const PatchMesh& mesh, std::uint32_t v) {
  return mesh.points[v].on_field && mesh.is_inner(v);
}

}  // namespace

void Relaxer::smooth(std::span<PatchMesh* const> parts, int passes) {
  const Chosen chosen = [&](std::size_t p, std::uint32_t v) {
    return parts[p]->points[v].on_field && parts[p]->is_whole(v);
  };
  if (load(parts, chosen)) {
    backend_.relax_smooth(goal_.field, goal_.sizes, places_of(goal_), view(), passes,
                          points_.view());
    take_points(parts);
  }
  for_each_part(backend_, parts, [&](PatchMesh& part) { smooth_off_field(part, goal_); });
}

void Relaxer::equalise(std::span<PatchMesh* const> parts, int passes) {
  const Chosen chosen = [&](std::size_t p, std::uint32_t v) {
    return is_inner_on_field(*parts[p], v);
  };
  if (load(parts, chosen)) {
    backend_.relax_equalise(goal_.field, goal_.sizes, places_of(goal_), view(), passes, true,
                            points_.view());
    take_points(parts);
  }
  for_each_part(backend_, parts, [&](PatchMesh& part) { equalise_off_field(part, goal_, passes); });
}

struct Relaxer::Crowd {
  std::vector<std::uint8_t> held;  ///< a byte a vertex
  std::vector<std::uint32_t> vertices;
  std::optional<Clearance> clearance;

  explicit Crowd(const PatchMesh& part) : held(crowded_vertices(part)) {
    for (std::uint32_t v = 0; v < part.vertex_count(); ++v)
      if (held[v] && part.is_there(v) && part.is_inner(v)) vertices.push_back(v);
    if (!vertices.empty()) clearance.emplace(part, held);
  }
};

/// All gaps first, then all moves.
void Relaxer::fit(std::span<PatchMesh* const> parts, int passes) {
  std::vector<std::optional<Crowd>> crowds(parts.size());
  backend_.run(parts.size(), [&](std::size_t p) {
    take_normals(*parts[p], goal_.field);
    crowds[p].emplace(*parts[p]);
  });
  const Chosen chosen = [&](std::size_t p, std::uint32_t v) {
    return !crowds[p]->held[v] && is_inner_on_field(*parts[p], v);
  };
  const bool any = load(parts, chosen);
  if (any) find_gaps();
  backend_.run(parts.size(), [&](std::size_t p) {
    fit_part(*parts[p], gaps_of(*parts[p], p, *crowds[p]), *crowds[p]);
  });
  if (any) {
    load_points(parts);
    backend_.relax_equalise(goal_.field, goal_.sizes, places_of(goal_), view(), passes, false,
                            points_.view());
    take_points(parts);
  }
  backend_.run(parts.size(), [&](std::size_t p) {
    PatchMesh& part = *parts[p];
    Crowd& crowd = *crowds[p];
    if (crowd.clearance) equalise_carefully(part, goal_, crowd.vertices, passes, *crowd.clearance);
    for (std::uint32_t v = 0; v < part.vertex_count(); ++v)
      if (part.is_there(v) && part.is_inner(v)) part.points[v].on_field = false;
  });
}

void Relaxer::find_gaps() {
  gaps_.resize(backend_, vertex_.size());
  backend_.relax_gaps(goal_.field, view(), std::as_const(points_).view(), gaps_.view());
  backend_.on_host(std::as_const(gaps_).view());
}

/// The gaps at the vertices of a part that are to be moved, by the backend or the host; 0
/// elsewhere.
std::vector<float> Relaxer::gaps_of(const PatchMesh& part, std::size_t p,
                                    const Crowd& crowd) const {
  std::vector<float> gaps(part.vertex_count(), 0.0f);
  for (std::size_t f = start_.fan[p]; f < start_.fan[p + 1]; ++f)
    gaps[vertex_.view()[f] - start_.point[p]] = gaps_.view()[f];
  std::vector<std::uint32_t> ring;
  for (const std::uint32_t v : crowd.vertices) {
    part.take_turn();
    if (!part.points[v].on_field) continue;
    ring.clear();
    add_ring(part, v, ring);
    const SurfacePoint& point = part.points[v];
    gaps[v] = mean_gap({part.points.data(), ring}, point, [&](std::size_t i) {
      return edge_gap(goal_.field, point, part.points[ring[i]]);
    });
  }
  return gaps;
}

/// In the order of the vertices' numbers.
void Relaxer::fit_part(PatchMesh& part, const std::vector<float>& gaps, Crowd& crowd) {
  SurfacePoint moved;
  for (std::uint32_t v = 0; v < part.vertex_count(); ++v) {
    part.take_turn();
    if (gaps[v] == 0 || !find_fit(part, v, gaps[v], moved)) continue;
    if (crowd.held[v])
      crowd.clearance->move_if_clear(part, v, moved);
    else
      part.points[v] = moved;
  }
}

/// A vertex's level is one above those of its neighbours that come before it.
Relaxer::Fans Relaxer::fans_of(const PatchMesh& part, std::size_t p, const Chosen& chosen) {
  std::vector<std::uint32_t> vertex, level, ring_first{0}, ring;
  std::vector<std::uint32_t> level_at(part.vertex_count(), 0), size;
  for (std::uint32_t v = 0; v < part.vertex_count(); ++v) {
    part.take_turn();
    if (!part.is_there(v) || !chosen(p, v)) continue;
    add_ring(part, v, ring);
    std::uint32_t above = 0;
    for (std::size_t i = ring_first.back(); i < ring.size(); ++i)
      above = std::max(above, level_at[ring[i]]);
    level_at[v] = above + 1;
    if (size.size() == above) size.push_back(0);
    ++size[above];
    vertex.push_back(v);
    level.push_back(above);
    ring_first.push_back(static_cast<std::uint32_t>(ring.size()));
  }
  Fans fans;
  fans.level_first.push_back(0);
  for (std::uint32_t count : size) fans.level_first.push_back(fans.level_first.back() + count);
  std::vector<std::uint32_t> order(vertex.size());
  std::vector<std::uint32_t> next(fans.level_first.begin(), fans.level_first.end() - 1);
  for (std::uint32_t f = 0; f < vertex.size(); ++f) order[next[level[f]]++] = f;
  for (std::uint32_t f : order) {
    fans.vertex.push_back(vertex[f]);
    fans.ring_first.push_back(static_cast<std::uint32_t>(fans.ring.size()));
    fans.ring.insert(fans.ring.end(), ring.begin() + ring_first[f],
                     ring.begin() + ring_first[f + 1]);
  }
  return fans;
}

void Relaxer::count(std::span<PatchMesh* const> parts, const std::vector<Fans>& fans) {
  start_ = {{0}, {0}, {0}, {0}};
  const auto add = [](std::vector<std::uint32_t>& starts, std::size_t count) {
    starts.push_back(starts.back() + static_cast<std::uint32_t>(count));
  };
  for (std::size_t p = 0; p < parts.size(); ++p) {
    add(start_.point, parts[p]->points.size());
    add(start_.level, fans[p].level_first.size() - 1);
    add(start_.fan, fans[p].vertex.size());
    add(start_.ring, fans[p].ring.size());
  }
}

bool Relaxer::load(std::span<PatchMesh* const> parts, const Chosen& chosen) {
  std::vector<Fans> fans(parts.size());
  backend_.run(parts.size(), [&](std::size_t p) { fans[p] = fans_of(*parts[p], p, chosen); });
  count(parts, fans);
  const std::size_t levels = start_.level.back(), all = start_.fan.back();
  if (all == 0) return false;
  points_.resize(backend_, start_.point.back());
  part_level_.resize(backend_, parts.size() + 1);
  level_first_.resize(backend_, levels + 1);
  vertex_.resize(backend_, all);
  ring_first_.resize(backend_, all + 1);
  ring_.resize(backend_, start_.ring.back());
  backend_.upload<std::uint32_t>(part_level_.view(), start_.level);
  for (Buffer<std::uint32_t>* lists : {&level_first_, &vertex_, &ring_first_, &ring_})
    backend_.on_host(lists->view());
  level_first_.view()[levels] = start_.fan.back();
  ring_first_.view()[all] = start_.ring.back();
  backend_.run(parts.size(), [&](std::size_t p) { load_fans(fans[p], p); });
  load_points(parts);
  return true;
}

void Relaxer::load_fans(const Fans& fans, std::size_t p) {
  const auto copy = [](std::span<const std::uint32_t> from, std::uint32_t shift,
                       std::uint32_t* to) {
    std::transform(from.begin(), from.end(), to,
                   [shift](std::uint32_t entry) { return entry + shift; });
  };
  const std::span levels(fans.level_first);
  const std::uint32_t point = start_.point[p], fan = start_.fan[p], ring = start_.ring[p];
  copy(levels.first(levels.size() - 1), fan, level_first_.view().data() + start_.level[p]);
  copy(fans.vertex, point, vertex_.view().data() + fan);
  copy(fans.ring_first, ring, ring_first_.view().data() + fan);
  copy(fans.ring, point, ring_.view().data() + ring);
}

void Relaxer::load_points(std::span<PatchMesh* const> parts) {
  const auto points = backend_.on_host(points_.view());
  backend_.run(parts.size(), [&](std::size_t p) {
    std::copy(parts[p]->points.begin(), parts[p]->points.end(), points.begin() + start_.point[p]);
  });
}

void Relaxer::take_points(std::span<PatchMesh* const> parts) {
  const auto points = backend_.on_host(std::as_const(points_).view());
  backend_.run(parts.size(), [&](std::size_t p) {
    std::copy_n(points.begin() + start_.point[p], parts[p]->points.size(),
                parts[p]->points.begin());
  });
}

FanView Relaxer::view() const {
  return {part_level_.view(), level_first_.view(), vertex_.view(), ring_first_.view(),
          ring_.view()};
}

}  // namespace vasamesh

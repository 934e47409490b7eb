#include "stages/patch_clearance.h"

#include <algorithm>
#include <bit>

#include "stages/intersect.h"

namespace vasamesh {

namespace {

constexpr float kInverseSide = 1.0f;  // of a cell, in voxel lengths

const Vec3& place(const PatchMesh& mesh, std::uint32_t v) { return mesh.points[v].position; }

/// Whether two triangles, given by their vertices, meet beyond what they share.
bool meet(const PatchMesh& mesh, const Clearance::Corners& a, const Clearance::Corners& b) {
  float at[6][3];
  const auto named = [&](const Clearance::Corners& triangle, float(*places)[3]) {
    for (int i = 0; i < 3; ++i) {
      const Vec3& p = place(mesh, triangle[i]);
      places[i][0] = p.x, places[i][1] = p.y, places[i][2] = p.z;
    }
    return NamedTriangle{triangle, {places[0], places[1], places[2]}};
  };
  return triangles_intersect(named(a, at), named(b, at + 3));
}

Clearance::Corners corners_of(const PatchMesh& mesh, std::uint32_t face) {
  return {mesh.origin(4 * face), mesh.origin(4 * face + 1), mesh.origin(4 * face + 2)};
}

}  // namespace

struct Clearance::Box {
  Vec3 low, high;

  Box(const PatchMesh& mesh, const Corners& t) : low(place(mesh, t[0])), high(low) {
    take_in(place(mesh, t[1]));
    take_in(place(mesh, t[2]));
  }
  void take_in(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  bool meets(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y && low.z <= other.high.z && other.low.z <= high.z;
  }
  /// The cells that it meets. Positions are not negative.
  CellRange cells() const {
    const auto cell = [](float x) { return static_cast<std::uint32_t>(kInverseSide * x); };
    return {{cell(low.x), cell(low.y), cell(low.z)}, {cell(high.x), cell(high.y), cell(high.z)}};
  }
};

struct Clearance::Candidate {
  Corners corners;
  Box box;
};

/// visit(slot) for the slots of the cells.
template <class Visit>
void Clearance::for_each_slot(const CellRange& cells, const Visit& visit) const {
  const auto mask = static_cast<std::uint32_t>(head_.size() - 1);
  for (std::uint32_t z = cells.low[2]; z <= cells.high[2]; ++z)
    for (std::uint32_t y = cells.low[1]; y <= cells.high[1]; ++y)
      for (std::uint32_t x = cells.low[0]; x <= cells.high[0]; ++x)
        visit((x * 73856093u ^ y * 19349663u ^ z * 83492791u) & mask);
}

Clearance::Clearance(const PatchMesh& mesh) {
  const std::size_t faces = mesh.half_edge_end() / 4;
  head_.assign(std::bit_ceil(2 * faces + 1), PatchMesh::kNone);
  entries_.reserve(8 * faces);
  for (std::uint32_t h = 0; h < mesh.half_edge_end(); h += 4)
    if (mesh.is_edge(h)) take_up(mesh, h);
}

Clearance::~Clearance() = default;
Clearance::Clearance(Clearance&&) noexcept = default;
Clearance& Clearance::operator=(Clearance&&) noexcept = default;

void Clearance::take_up(const PatchMesh& mesh, std::uint32_t h) {
  const std::uint32_t face = h / 4;
  const CellRange cells = Box(mesh, corners_of(mesh, face)).cells();
  if (face >= taken_.size()) taken_.resize(mesh.half_edge_end() / 4);
  if (taken_[face].holds(cells)) return;
  taken_[face] = cells;
  for_each_slot(cells, [&](std::uint32_t slot) {
    for (std::uint32_t e = head_[slot]; e != PatchMesh::kNone; e = entries_[e].next)
      if (entries_[e].face == face) return;
    entries_.push_back({face, head_[slot]});
    head_[slot] = static_cast<std::uint32_t>(entries_.size() - 1);
  });
}

/// The triangles of the part, but those of the half-edges `gone`, whose boxes meet another.
void Clearance::find_candidates(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                                const Box& around) {
  candidates_.clear();
  seen_.resize(mesh.half_edge_end() / 4, 0);
  ++stamp_;
  for (std::uint32_t h : gone) seen_[h / 4] = stamp_;
  for_each_slot(around.cells(), [&](std::uint32_t slot) {
    for (std::uint32_t e = head_[slot]; e != PatchMesh::kNone; e = entries_[e].next) {
      const std::uint32_t face = entries_[e].face;
      if (seen_[face] == stamp_ || !mesh.is_edge(4 * face)) continue;
      seen_[face] = stamp_;
      const Corners corners = corners_of(mesh, face);
      if (const Box box(mesh, corners); box.meets(around)) candidates_.push_back({corners, box});
    }
  });
}

bool Clearance::is_clear(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                         std::span<const Corners> made) {
  if (made.empty()) return true;
  Box around(mesh, made[0]);
  for (const Corners& t : made)
    for (const std::uint32_t v : t) around.take_in(place(mesh, v));
  find_candidates(mesh, gone, around);
  for (std::size_t i = 0; i < made.size(); ++i) {
    const Box box(mesh, made[i]);
    for (std::size_t j = 0; j < i; ++j)
      if (box.meets(Box(mesh, made[j])) && meet(mesh, made[i], made[j])) return false;
    for (const Candidate& other : candidates_)
      if (box.meets(other.box) && meet(mesh, made[i], other.corners)) return false;
  }
  return true;
}

bool Clearance::flip_if_clear(PatchMesh& mesh, std::uint32_t h) {
  const std::uint32_t t = mesh.twin(h), p = mesh.origin(h), q = mesh.target(h), c = mesh.apex(h),
                      d = mesh.apex(t);
  const std::uint32_t gone[2] = {h, t};
  const Corners made[2] = {{d, c, p}, {c, d, q}};
  if (!is_clear(mesh, gone, made)) return false;
  mesh.flip(h);
  for (const std::uint32_t g : gone) take_up(mesh, g);
  return true;
}

bool Clearance::move_if_clear(PatchMesh& mesh, std::uint32_t v, const SurfacePoint& point) {
  const SurfacePoint old = mesh.points[v];
  mesh.points[v] = point;
  fan_.clear();
  fan_corners_.clear();
  mesh.for_each_out(v, [&](std::uint32_t h) {
    fan_.push_back(h);
    fan_corners_.push_back({v, mesh.target(h), mesh.apex(h)});
  });
  if (!is_clear(mesh, fan_, fan_corners_)) {
    mesh.points[v] = old;
    return false;
  }
  for (std::uint32_t h : fan_) take_up(mesh, h);
  return true;
}

}  // namespace vasamesh

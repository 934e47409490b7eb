#include "stages/patch_clearance.h"

#include <algorithm>

#include "stages/intersect.h"

namespace vasamesh {

namespace {

constexpr float kSide = 4;        // of a cell, in mean half sides of a triangle's box
constexpr float kSlack = 1.001f;  // for the rounding of middles
constexpr std::uint32_t kAmongLarge = PatchMesh::kNone - 1;  // no slot: in the list of large ones

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

Box box_round(const PatchMesh& mesh, const Clearance::Corners& t) {
  Box box = {place(mesh, t[0]), place(mesh, t[0])};
  box.take_in(place(mesh, t[1]));
  box.take_in(place(mesh, t[2]));
  return box;
}

/// Of the box's longest side.
float half_side(const Box& box) { return 0.5f * box.longest_side(); }

}  // namespace

/// Takes up the triangles of the half-edges h, the first of each, for which wanted(h) says so.
template <class Wanted>
void Clearance::take_up_all(const PatchMesh& mesh, const Wanted& wanted) {
  std::vector<std::uint32_t> chosen;
  float sum = 0;
  for (std::uint32_t h = 0; h < mesh.half_edge_end(); h += 4) {
    mesh.take_turn();
    if (!mesh.is_edge(h) || !wanted(h)) continue;
    chosen.push_back(h);
    sum += half_side(box_round(mesh, mesh.corners(h)));
  }
  const float inverse_side = sum > 0 ? static_cast<float>(chosen.size()) / (kSide * sum) : 1.0f;
  cells_ = CellHash(inverse_side, chosen.size());
  head_.assign(cells_.slots(), PatchMesh::kNone);
  entries_.reserve(chosen.size());
  faces_.resize(mesh.half_edge_end() / 4);
  for (const std::uint32_t h : chosen) {
    mesh.take_turn();
    take_up(mesh, h);
  }
}

Clearance::Clearance(const PatchMesh& mesh) : shells_(mesh) {
  take_up_all(mesh, [](std::uint32_t) { return true; });
}

Clearance::Clearance(const PatchMesh& mesh, std::span<const std::uint8_t> wanted) : shells_(mesh) {
  take_up_all(mesh, [&](std::uint32_t h) {
    return wanted[mesh.origin(h)] || wanted[mesh.target(h)] || wanted[mesh.apex(h)];
  });
}

void Clearance::take_up(const PatchMesh& mesh, std::uint32_t h) {
  const std::uint32_t index = h / 4;
  const Box box = box_round(mesh, mesh.corners(4 * index));
  shells_.take_up(mesh, h);
  if (index >= faces_.size()) faces_.resize(mesh.half_edge_end() / 4);
  Face& face = faces_[index];
  face.box = box;
  const bool large = half_side(box) * cells_.inverse_side() > 1;
  const std::uint32_t slot = large ? kAmongLarge : cells_.slot_of(box.middle());
  if (!large) reach_ = std::max(reach_, kSlack * half_side(box));
  if (face.slot == slot) return;
  face.slot = slot;
  if (large) return large_.push_back(index);
  entries_.push_back({index, head_[slot]});
  head_[slot] = static_cast<std::uint32_t>(entries_.size() - 1);
}

/// Takes a triangle as a candidate that was not seen before and whose box meets another.
void Clearance::consider(const PatchMesh& mesh, std::uint32_t index, const Box& around) {
  Face& face = faces_[index];
  if (face.seen == stamp_ || !face.box.meets(around)) return;
  face.seen = stamp_;
  if (mesh.is_edge(4 * index)) candidates_.push_back({mesh.corners(4 * index), face.box});
}

/// The triangles of the part, but those of the half-edges `gone`, whose boxes meet another. Forgets
/// the entries of triangles that have moved on to other slots.
void Clearance::find_candidates(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                                const Box& around) {
  candidates_.clear();
  ++stamp_;
  for (std::uint32_t h : gone)
    if (h / 4 < faces_.size()) faces_[h / 4].seen = stamp_;
  cells_.for_each_slot(around.widened(reach_), [&](std::uint32_t slot) {
    for (std::uint32_t* link = &head_[slot]; *link != PatchMesh::kNone;) {
      Entry& entry = entries_[*link];
      if (faces_[entry.face].slot != slot) {
        *link = entry.next;
        continue;
      }
      consider(mesh, entry.face, around);
      link = &entry.next;
    }
  });
  for (const std::uint32_t index : large_) consider(mesh, index, around);
}

bool Clearance::is_clear(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                         std::span<const Corners> made) {
  mesh.take_turn();
  if (made.empty()) return true;
  if (!shells_.keep_volume(mesh, gone, made)) return false;
  Box around = box_round(mesh, made[0]);
  for (const Corners& t : made)
    for (const std::uint32_t v : t) around.take_in(place(mesh, v));
  find_candidates(mesh, gone, around);
  for (std::size_t i = 0; i < made.size(); ++i) {
    const Box box = box_round(mesh, made[i]);
    for (std::size_t j = 0; j < i; ++j)
      if (box.meets(box_round(mesh, made[j])) && meet(mesh, made[i], made[j])) return false;
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

#include "stages/expand_propose.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "stages/expand_checks.h"
#include "stages/expand_front.h"
#include "stages/expand_place.h"
#include "stages/expand_rules.h"
#include "types/segment.h"

namespace vasamesh {

using namespace expand_rules;

namespace {

/// The parts that an open angle is cut into.
int parts_of(float angle) {
  if (angle < kEarAngle) return 1;
  return std::clamp(static_cast<int>(angle / kPart + 0.5f), 2, kMostNewVertices + 1);
}

class Proposer {
 public:
  Proposer(const FieldView& field, const SizeView& sizes, const FrontView& front,
           const FrontLimits& limits, const CellBox& claimed, std::uint32_t corner)
      : field_(field),
        sizes_(sizes),
        front_(front),
        limits_(limits),
        claimed_(claimed),
        corner_(corner),
        next_(front.corners[corner].next),
        previous_(front.corners[corner].previous),
        angle_(front.corners[corner].angle),
        here_(front.position_of(corner)),
        up_(front.normal_of(corner)),
        length_(front.vertex_of(corner).size) {}

  Proposal run(std::vector<BoundaryEdge>& near);

 private:
  const Vec3& at(std::uint32_t corner) const { return front_.position_of(corner); }
  const Vec3& up(std::uint32_t corner) const { return front_.normal_of(corner); }
  std::uint32_t next_of(std::uint32_t corner) const { return front_.corners[corner].next; }
  std::uint32_t previous_of(std::uint32_t corner) const { return front_.corners[corner].previous; }
  std::uint32_t vertex_at(std::uint32_t corner) const { return front_.corners[corner].vertex; }
  float angle_at(std::uint32_t corner) const { return front_.corners[corner].angle; }

  /// Angle at a corner, counter-clockwise from one direction to another.
  float angle(std::uint32_t corner, const Vec3& from, const Vec3& to) const {
    return angle_between(at(corner), up(corner), from, to);
  }

  static Proposal make(Proposal::Kind kind, std::uint32_t target = kNoEntry) {
    Proposal proposal;
    proposal.kind = kind;
    proposal.target = target;
    return proposal;
  }

  /// Whether the corner's links may be changed: no other claim reaches it.
  bool owns(std::uint32_t corner) const {
    const auto cell = cell_at(field_, at(corner));
    return claimed_.holds(cell) && cell_index(field_, cell) < cell_count(field_);
  }

  Proposal close_three() const;
  Proposal try_ear() const;
  Proposal try_fan(const Proposal& placed, bool& narrow) const;
  Proposal try_join(const Vec3& place_next, const Vec3& place_previous, bool one_place,
                    float reach) const;
  Proposal try_target(std::uint32_t target, bool with_next, bool with_previous) const;

  bool place(int parts, Proposal& placed) const;
  std::uint32_t nearest_target(const Vec3& place, float reach) const;
  bool room_at_target(std::uint32_t target, bool with_next, bool with_previous) const;
  bool room_at_next(const Vec3& to, bool is_edge) const;
  bool room_at_previous(const Vec3& to, bool is_edge) const;
  bool good_triangle(const Triangle& t, const std::array<Vec3, 3>& normals, float tau) const;
  bool too_near(const BoundaryEdge& edge, const Proposal& placed,
                std::span<const Triangle> triangles, float longest) const;
  bool is_covered(const Vec3& p, const Vec3& normal) const;
  bool good_edge(const Vec3& a, const Vec3& b) const;
  bool clear_of_edges(std::span<const Triangle> triangles) const;
  bool is_own(const BoundaryEdge& edge) const {
    return edge.corner == corner_ || edge.corner == previous_;
  }

  const FieldView& field_;
  const SizeView& sizes_;
  const FrontView& front_;
  const FrontLimits& limits_;
  const CellBox& claimed_;
  const std::uint32_t corner_, next_, previous_;
  const float angle_;
  const Vec3 here_, up_;
  const float length_;
  std::span<const BoundaryEdge> edges_;
};

bool Proposer::good_triangle(const Triangle& t, const std::array<Vec3, 3>& normals,
                             float tau) const {
  return edge_ratio(t) >= tau && faces_outward(t, normals);
}

bool Proposer::good_edge(const Vec3& a, const Vec3& b) const {
  const float most = kLongestEdge * length_;
  return squared_norm(b - a) <= most * most && edge_on_surface(field_, a, b, limits_.off_surface);
}

bool Proposer::clear_of_edges(std::span<const Triangle> triangles) const {
  for (const BoundaryEdge& edge : edges_) {
    if (is_own(edge)) continue;
    for (const Triangle& t : triangles)
      if (edge_crosses(edge, t)) return false;
  }
  return true;
}

/// Whether the next corner keeps a useful angle when an edge leads from it to `to`.
bool Proposer::room_at_next(const Vec3& to, bool is_edge) const {
  if (is_edge) return true;
  return angle_at(next_) - angle(next_, here_, to) >= limits_.least_angle;
}

bool Proposer::room_at_previous(const Vec3& to, bool is_edge) const {
  if (is_edge) return true;
  return angle_at(previous_) - angle(previous_, to, here_) >= limits_.least_angle;
}

/// Whether triangles to the next corner, the previous one or both fit into the target's open side,
/// leaving nothing or a useful angle before and after them.
bool Proposer::room_at_target(std::uint32_t target, bool with_next, bool with_previous) const {
  const Vec3& first = with_next ? at(next_) : here_;
  const Vec3& last = with_previous ? at(previous_) : here_;
  const bool meets_before = with_next && previous_of(target) == next_;
  const bool meets_after = with_previous && next_of(target) == previous_;
  const float used = angle(target, first, last);
  const float before = meets_before ? 0.0f : angle(target, at(previous_of(target)), first);
  const float after = meets_after ? 0.0f : angle(target, last, at(next_of(target)));
  return before + used + after <= angle_at(target) + kSpareAngle &&
         (meets_before || before >= limits_.least_angle) &&
         (meets_after || after >= limits_.least_angle);
}

Proposal Proposer::close_three() const {
  const Triangle t = {here_, at(previous_), at(next_)};
  if (!good_triangle(t, {up_, up(previous_), up(next_)}, kGapTau * limits_.least_tau)) return {};
  return make(Proposal::ear);
}

Proposal Proposer::try_ear() const {
  const float open = angle_;
  if (open < limits_.least_angle) return {};
  const Triangle t = {here_, at(previous_), at(next_)};
  if (!good_triangle(t, {up_, up(previous_), up(next_)}, limits_.least_tau)) return {};
  if (!room_at_next(at(previous_), false) || !room_at_previous(at(next_), false)) return {};
  if (!good_edge(at(previous_), at(next_)) || !clear_of_edges({&t, 1})) return {};
  return make(Proposal::ear);
}

/// Places the new vertices of a fan: at equal angles, as far as the sizes ask.
bool Proposer::place(int parts, Proposal& placed) const {
  const Vec3 to_next = at(next_) - here_;
  const Vec3 across = normalised(to_next - dot(to_next, up_) * up_);
  if (!(squared_norm(across) > 0)) return false;
  const Vec3 left = cross(up_, across);
  const float near = 0.5f * (norm(to_next) + norm(at(previous_) - here_));
  const Rotation part = rotation_by(angle_ / static_cast<float>(parts));
  Rotation turn;
  placed.vertices = static_cast<std::uint8_t>(parts - 1);
  for (std::size_t i = 0; i < placed.vertices; ++i) {
    turn = turn.then(part);
    const Vec3 direction = turn.cosine * across - turn.sine * left;
    const float there = size_at(sizes_, here_ + length_ * direction);
    const float edge = std::clamp(0.5f * (length_ + there), kSmaller * near, kLarger * near);
    if (!place_on_surface(field_, here_, direction, edge, placed.position[i], placed.normal[i]))
      return false;
    placed.size[i] = size_at(sizes_, placed.position[i]);
  }
  return true;
}

/// Whether the mesh is there already: an inner vertex of this sheet lies as near as it does to any
/// point of a regular mesh. Without this, a front that slips under another would not stop.
bool Proposer::is_covered(const Vec3& p, const Vec3& normal) const {
  return any_near(field_, front_, p, kCovered * length_, [&](const FrontVertex& v) {
    return v.corners == 0 && dot(v.normal, normal) > kSameSheet;
  });
}

/// The paper's rule of one third of the longest edge: for the new vertices and a boundary edge, and
/// for the edge's start and the edges that the fan puts on the boundary.
bool Proposer::too_near(const BoundaryEdge& edge, const Proposal& placed,
                        std::span<const Triangle> triangles, float longest) const {
  if (!(dot(edge.normal, up_) > kSameSheet)) return false;
  const float least = kNarrow * std::max(longest, norm(edge.end - edge.start));
  for (std::size_t i = 0; i < placed.vertices; ++i)
    if (squared_to_segment(placed.position[i], edge.start, edge.end) < least * least) return true;
  if (edge.start == at(next_) || edge.start == at(previous_) || edge.start == here_) return false;
  const bool after = edge.corner == next_of(next_);
  const bool before = edge.corner == previous_of(previous_);
  for (std::size_t i = after ? 1 : 0; i < triangles.size() - (before ? 1 : 0); ++i)
    if (squared_to_segment(edge.start, triangles[i][1], triangles[i][2]) < least * least)
      return true;
  return false;
}

Proposal Proposer::try_fan(const Proposal& placed, bool& narrow) const {
  std::array<Triangle, kMostNewVertices + 1> triangles;
  const std::size_t count = placed.vertices;
  float longest = 0;
  for (std::size_t i = 0; i <= count; ++i) {
    const Vec3& from = i == 0 ? at(next_) : placed.position[i - 1];
    const Vec3& to = i == count ? at(previous_) : placed.position[i];
    triangles[i] = {here_, to, from};
    if (!good_triangle(triangles[i],
                       {up_, i == count ? up(previous_) : placed.normal[i],
                        i == 0 ? up(next_) : placed.normal[i - 1]},
                       kFanTau))
      return {};
    longest = std::max(longest, longest_edge(triangles[i]));
    if (!good_edge(from, to) || (i < count && !good_edge(here_, to))) return {};
  }
  if (!room_at_next(placed.position[0], false) ||
      !room_at_previous(placed.position[count - 1], false))
    return {};
  for (std::size_t i = 0; i < count; ++i)
    if (is_covered(placed.position[i], placed.normal[i])) return {};
  narrow = true;
  for (const BoundaryEdge& edge : edges_)
    if (!is_own(edge) && too_near(edge, placed, {triangles.data(), count + 1}, longest)) return {};
  if (!clear_of_edges({triangles.data(), count + 1})) return {};
  narrow = false;
  for (std::size_t i = 0; i < count; ++i)
    if (!claimed_.holds(cell_at(field_, placed.position[i]))) return make(Proposal::more_room);
  Proposal proposal = placed;
  proposal.kind = Proposal::fan;
  return proposal;
}

/// The corner of this sheet nearest to a place where a new vertex would lie.
std::uint32_t Proposer::nearest_target(const Vec3& place, float reach) const {
  std::uint32_t best = kNoEntry;
  float least = reach * reach;
  for (const BoundaryEdge& edge : edges_) {
    const float apart = squared_norm(edge.start - place);
    if (apart > least || (apart == least && edge.corner >= best)) continue;
    if (edge.corner == corner_ || edge.corner == next_ || edge.corner == previous_) continue;
    const std::uint32_t v = vertex_at(edge.corner);
    if (v == vertex_at(corner_) || v == vertex_at(next_) || v == vertex_at(previous_)) continue;
    if (!(dot(edge.normal, up_) > kSameSheet)) continue;
    least = apart;
    best = edge.corner;
  }
  return best;
}

Proposal Proposer::try_target(std::uint32_t target, bool with_next, bool with_previous) const {
  const Vec3& to = at(target);
  const bool follows = next_of(next_) == target, precedes = previous_of(previous_) == target;
  std::array<Triangle, 2> triangles;
  std::size_t count = 0;
  if (with_next) {
    triangles[count++] = {here_, to, at(next_)};
    if (!good_triangle(triangles[count - 1], {up_, up(target), up(next_)}, limits_.least_tau) ||
        !room_at_next(to, follows) || (!follows && !good_edge(at(next_), to)))
      return {};
  }
  if (with_previous) {
    triangles[count++] = {here_, at(previous_), to};
    if (!good_triangle(triangles[count - 1], {up_, up(previous_), up(target)}, limits_.least_tau) ||
        !room_at_previous(to, precedes) || (!precedes && !good_edge(at(previous_), to)))
      return {};
  }
  const float to_next = angle(corner_, to, at(next_));
  const float to_previous = angle_ - to_next;
  if (to_previous < limits_.least_angle || to_next < limits_.least_angle) return {};
  if (!room_at_target(target, with_next, with_previous) || !good_edge(here_, to) ||
      !clear_of_edges({triangles.data(), count}))
    return {};
  for (const std::uint32_t corner :
       {next_, previous_, target, next_of(target), previous_of(target)})
    if (!owns(corner)) return make(Proposal::more_room);
  return make(with_next && with_previous ? Proposal::join_both
              : with_next                ? Proposal::join_next
                                         : Proposal::join_previous,
              target);
}

Proposal Proposer::try_join(const Vec3& place_next, const Vec3& place_previous, bool one_place,
                            float reach) const {
  const std::uint32_t by_next = nearest_target(place_next, reach);
  const std::uint32_t by_previous = one_place ? by_next : nearest_target(place_previous, reach);
  if (by_next != kNoEntry && by_next == by_previous) {
    const Proposal both = try_target(by_next, true, true);
    if (both.kind != Proposal::nothing) return both;
  }
  if (by_next != kNoEntry) {
    const Proposal one = try_target(by_next, true, false);
    if (one.kind != Proposal::nothing) return one;
  }
  if (by_previous != kNoEntry) return try_target(by_previous, false, true);
  return {};
}

Proposal Proposer::run(std::vector<BoundaryEdge>& near) {
  if (next_ == previous_ || next_ == corner_) return {};
  if (!owns(corner_) || !owns(next_) || !owns(previous_)) return make(Proposal::more_room);
  // A loop of three is a gap to close, or the border of a lone triangle.
  if (front_.in_loop_of_three(corner_) && angle_ < kPi) return close_three();
  near.clear();
  gather_edges(field_, front_, cells_round(field_, here_, kSearch * length_), near);
  edges_ = near;
  const int parts = parts_of(angle_);
  if (parts == 1) return try_ear();

  Proposal placed;
  if (!place(parts, placed)) return {};
  const Vec3& first = placed.position[0];
  const Vec3& last = placed.position[placed.vertices - 1u];
  const float reach = limits_.join_reach * length_;
  const Proposal join = try_join(first, last, placed.vertices == 1, reach);
  if (join.kind != Proposal::nothing) return join;
  bool narrow = false;
  const Proposal fan = try_fan(placed, narrow);
  if (fan.kind != Proposal::nothing || !narrow) return fan;
  return try_join(first, last, placed.vertices == 1, kWiderJoin * reach);
}

}  // namespace

Proposal propose(const FieldView& field, const SizeView& sizes, const FrontView& front,
                 const FrontLimits& limits, const CellBox& claimed, std::uint32_t corner,
                 std::vector<BoundaryEdge>& near) {
  return Proposer(field, sizes, front, limits, claimed, corner).run(near);
}

}  // namespace vasamesh

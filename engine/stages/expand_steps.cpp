#include "stages/expand_steps.h"

#include <atomic>

#include "stages/expand_front.h"
#include "stages/expand_rules.h"

namespace vasamesh {

using namespace expand_rules;

namespace {

/// Which corners go first: those that close, then the narrow ones.
std::uint32_t rank_of(const FrontView& front, std::uint32_t corner) {
  if (front.in_loop_of_three(corner)) return 7;
  constexpr float kUpTo[] = {3.9f, 3.4f, 2.75f, 2.2f, 1.75f};
  const float angle = front.corners[corner].angle;
  std::uint32_t rank = 1;
  for (const float limit : kUpTo) rank += angle < limit;
  return rank;
}

/// Mixes the bits of an index, so that neighbours are not served in order.
std::uint32_t scramble(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ x >> 16;
}

std::uint32_t key_of(const FrontView& front, std::uint32_t corner, std::uint32_t round) {
  const std::uint32_t mixed = scramble(corner + 0x9e3779b9u * round);
  return round << 20 | rank_of(front, corner) << 16 | (mixed & 0xffffu);
}

/// Puts an entry at the front of a list. \return what was there.
std::uint32_t push(std::uint32_t& head, std::uint32_t entry) {
  return std::atomic_ref(head).exchange(entry, std::memory_order_relaxed);
}

void link(const FrontView& front, std::uint32_t from, std::uint32_t to) {
  front.corners[from].next = to;
  front.corners[to].previous = from;
  front.corners[from].state = front.corners[to].state = CornerState::changed;
}

void kill(const FrontView& front, std::uint32_t corner) {
  front.corners[corner].state = CornerState::dead;
  --front.vertex_of(corner).corners;
}

void add_corner(const FrontView& front, std::uint32_t corner, std::uint32_t vertex) {
  const FrontCounts& counts = front.counts[0];
  front.corners[corner] = {.vertex = vertex};
  front.listed[counts.listed - counts.corners + corner] = corner;
}

/// The triangle of the edge from a corner to its next, with its tip at the corner `tip`: the
/// boundary runs past the tip instead. Where the tip is no neighbour it splits in two, and `spare`
/// is the second corner.
void fill_edge(const FrontView& front, std::uint32_t corner, std::uint32_t tip, std::uint32_t spare,
               std::uint32_t* triangle) {
  const std::uint32_t next = front.corners[corner].next;
  const std::uint32_t tip_vertex = front.corners[tip].vertex;
  triangle[0] = front.corners[corner].vertex;
  triangle[1] = tip_vertex;
  triangle[2] = front.corners[next].vertex;
  const bool follows = front.corners[next].next == tip;
  const bool precedes = front.corners[corner].previous == tip;
  if (follows && precedes) {
    for (const std::uint32_t c : {corner, next, tip}) kill(front, c);
  } else if (follows) {
    link(front, corner, tip);
    kill(front, next);
  } else if (precedes) {
    link(front, tip, next);
    kill(front, corner);
  } else {
    add_corner(front, spare, tip_vertex);
    ++front.vertices[tip_vertex].corners;
    link(front, front.corners[tip].previous, spare);
    link(front, spare, next);
    link(front, corner, tip);
  }
}

void add_vertex(const FieldView& field, const FrontView& front, std::uint32_t vertex,
                const Proposal& p, std::uint32_t k) {
  FrontVertex& added = front.vertices[vertex];
  added = {p.position[k], p.normal[k], p.size[k], 1};
  added.next_near =
      push(front.vertex_at[cell_index(field, cell_at(field, added.position))], vertex);
}

/// A fan of new vertices round the corner, from its next to its previous.
void add_fan(const FieldView& field, const FrontView& front, std::uint32_t corner,
             const Proposal& p, const FrontStart& start, std::uint32_t* triangle) {
  const std::uint32_t previous = front.corners[corner].previous;
  std::uint32_t last = front.corners[corner].next;
  for (std::uint32_t k = 0; k <= p.vertices; ++k) {
    const std::uint32_t here = k < p.vertices ? start.corner + k : previous;
    if (k < p.vertices) {
      add_vertex(field, front, start.vertex + k, p, k);
      add_corner(front, here, start.vertex + k);
    }
    triangle[3 * k] = front.corners[corner].vertex;
    triangle[3 * k + 1] = front.corners[here].vertex;
    triangle[3 * k + 2] = front.corners[last].vertex;
    link(front, here, last);
    last = here;
  }
  kill(front, corner);
}

}  // namespace

void measure_corner(const FieldView& field, const FrontView& front, std::uint32_t round, bool wake,
                    std::uint32_t corner) {
  FrontCorner& c = front.corners[corner];
  if (c.cell != kNoEntry)
    std::atomic_ref(front.edge_at[c.cell]).store(kNoEntry, std::memory_order_relaxed);
  c.key = 0;
  if (c.state == CornerState::dead) return;
  if (wake || c.state == CornerState::changed) {
    const FrontVertex& here = front.vertices[c.vertex];
    const Vec3& end = front.position_of(c.next);
    c.angle = angle_between(here.position, here.normal, front.position_of(c.previous), end);
    c.cell =
        static_cast<std::uint32_t>(cell_index(field, cell_at(field, 0.5f * (here.position + end))));
    c.state = CornerState::active;
    c.wide = 0;
  }
  if (c.state == CornerState::active) c.key = key_of(front, corner, round);
}

void list_edge(const FrontView& front, std::uint32_t corner) {
  FrontCorner& c = front.corners[corner];
  c.next_near = push(front.edge_at[c.cell], corner);
}

bool goes_first(const FrontView& front, std::uint32_t corner) {
  const FrontCorner& c = front.corners[corner];
  if (c.key == 0) return false;
  const std::uint64_t claim = claim_of(front, corner);
  return claim >= claim_of(front, c.previous) && claim >= claim_of(front, c.next) &&
         claim >= claim_of(front, front.corners[c.previous].previous) &&
         claim >= claim_of(front, front.corners[c.next].next);
}

CellBox claimed_cells(const FieldView& field, const FrontView& front, std::uint32_t corner) {
  const FrontVertex& v = front.vertex_of(corner);
  return cells_round(field, v.position,
                     (front.corners[corner].wide ? kWideClaim : kClaim) * v.size);
}

void claim_cells(const FieldView& field, const FrontView& front, std::uint32_t corner) {
  const std::uint64_t claim = claim_of(front, corner);
  for_cells(field, claimed_cells(field, front, corner), [&](std::size_t cell) {
    std::atomic_ref<std::uint64_t> held(front.claims[cell]);
    std::uint64_t old = held.load(std::memory_order_relaxed);
    while (old < claim && !held.compare_exchange_weak(old, claim, std::memory_order_relaxed)) {
    }
  });
}

bool holds_cells(const FieldView& field, const FrontView& front, std::uint32_t corner) {
  const std::uint64_t claim = claim_of(front, corner);
  return !any_cell(field, claimed_cells(field, front, corner),
                   [&](std::size_t cell) { return front.claims[cell] != claim; });
}

FrontStart needs_of(const FrontView& front, std::uint32_t corner, const Proposal& p) {
  const FrontCorner& c = front.corners[corner];
  const bool follows = p.target != kNoEntry && front.corners[c.next].next == p.target;
  const bool precedes = p.target != kNoEntry && front.corners[c.previous].previous == p.target;
  switch (p.kind) {
    case Proposal::ear:
      return {0, 1, 0};
    case Proposal::fan:
      return {p.vertices, p.vertices + 1u, p.vertices};
    case Proposal::join_next:
      return {0, 1, follows ? 0u : 1u};
    case Proposal::join_previous:
      return {0, 1, precedes ? 0u : 1u};
    case Proposal::join_both:
      return {0, 2, follows ? 0u : 1u};
    default:
      return {};
  }
}

void add_proposal(const FieldView& field, const FrontView& front, std::size_t i) {
  const Proposal& p = front.proposals[i];
  // Round a corner that may not hold its cells, others are at work.
  if (p.kind == Proposal::nothing || p.kind == Proposal::more_room) return;
  const FrontStart& start = front.starts[i];
  const std::uint32_t corner = front.chosen[i];
  const std::uint32_t next = front.corners[corner].next;
  const std::uint32_t previous = front.corners[corner].previous;
  std::uint32_t* triangle = front.triangles.data() + 3 * std::size_t{start.triangle};
  switch (p.kind) {
    case Proposal::ear:
      return fill_edge(front, previous, next, kNoEntry, triangle);
    case Proposal::join_next:
      return fill_edge(front, corner, p.target, start.corner, triangle);
    case Proposal::join_previous:
      return fill_edge(front, previous, p.target, start.corner, triangle);
    case Proposal::join_both:
      fill_edge(front, corner, p.target, start.corner, triangle);
      return fill_edge(front, previous, p.target, kNoEntry, triangle + 3);
    case Proposal::fan:
      return add_fan(field, front, corner, p, start, triangle);
    default:
      return;
  }
}

}  // namespace vasamesh

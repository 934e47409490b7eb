#include "stages/expand_rounds.h"

#include <algorithm>
#include <atomic>

namespace vasamesh {

namespace {

constexpr std::size_t kCornerGrain = 512;   // corners a task of the light passes takes
constexpr std::size_t kProposalGrain = 16;  // proposals a task takes

/// Which corners go first: those that close, then the narrow ones.
std::uint64_t rank_of(const Front& front, std::uint32_t corner) {
  if (front.in_loop_of_three(corner)) return 7;
  constexpr float kUpTo[] = {3.9f, 3.4f, 2.75f, 2.2f, 1.75f};
  const float angle = front.angle[corner];
  std::uint64_t rank = 1;
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

/// Later rounds have higher keys, so that no claim needs to be taken back; the corner makes the key
/// unique.
std::uint64_t key_of(const Front& front, std::uint32_t corner, int round) {
  const std::uint64_t mixed = scramble(corner + 0x9e3779b9u * static_cast<std::uint32_t>(round));
  return static_cast<std::uint64_t>(round) << 52 | rank_of(front, corner) << 48 |
         (mixed & 0xffffu) << 32 | corner;
}

struct Needs {
  std::uint32_t vertices, triangles, corners;
};

Needs needs_of(const Front& front, const Proposal& p) {
  const bool follows = p.target != kNone && front.next[front.next[p.corner]] == p.target;
  const bool precedes = p.target != kNone && front.previous[front.previous[p.corner]] == p.target;
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
      return {0, 0, 0};
  }
}

/// The triangle of the edge from a corner to its next, with its tip at the corner `tip`: the
/// boundary runs past the tip instead. Where the tip is no neighbour it splits in two, and `spare`
/// is the second corner.
void fill_edge(Front& front, std::uint32_t corner, std::uint32_t tip, std::uint32_t spare,
               std::uint32_t* triangle) {
  const std::uint32_t next = front.next[corner];
  triangle[0] = front.vertex[corner];
  triangle[1] = front.vertex[tip];
  triangle[2] = front.vertex[next];
  const bool follows = front.next[next] == tip, precedes = front.previous[corner] == tip;
  if (follows && precedes) {
    for (const std::uint32_t c : {corner, next, tip}) front.kill(c);
  } else if (follows) {
    front.link(corner, tip);
    front.kill(next);
  } else if (precedes) {
    front.link(tip, next);
    front.kill(corner);
  } else {
    front.vertex[spare] = front.vertex[tip];
    ++front.corners[front.vertex[tip]];
    front.link(front.previous[tip], spare);
    front.link(spare, next);
    front.link(corner, tip);
  }
}

}  // namespace

FrontRounds::FrontRounds(Backend& backend, const FieldView& field, const SizeView& sizes,
                         Front& front, std::size_t most_triangles)
    : backend_(backend),
      field_(field),
      sizes_(sizes),
      front_(front),
      grid_(field),
      vertices_(field),
      most_triangles_(most_triangles),
      claims_(cell_count(field), 0) {}

bool FrontRounds::run(const FrontLimits& limits) {
  constexpr int kMostRounds = 4000;
  for (int round = 0; round < kMostRounds; ++round) {
    measure_angles();
    if (front_.triangles.size() / 3 > most_triangles_) return false;
    if (!choose()) return true;
    ++rounds_;
    claim();
    grid_.build(backend_, front_);
    vertices_.update(front_);
    ask(limits);
    settle_failed();
    number();
    add();
    drop_dead();
  }
  return true;
}

void FrontRounds::measure_angles() {
  for_each(front_.alive.size(), kCornerGrain, [&](std::size_t i) {
    const std::uint32_t c = front_.alive[i];
    if (front_.state[c] != kChanged) return;
    front_.angle[c] = angle_between(front_.at(c), front_.normal_at(c),
                                    front_.at(front_.previous[c]), front_.at(front_.next[c]));
    front_.state[c] = kActive;
    front_.wide[c] = 0;
  });
}

/// Of the active corners, those that go before their neighbours, two to each side.
bool FrontRounds::choose() {
  keys_.resize(front_.vertex.size());
  const std::size_t count = front_.alive.size();
  chosen_.resize(count);
  for_each(count, kCornerGrain, [&](std::size_t i) {
    const std::uint32_t c = front_.alive[i];
    keys_[c] = front_.state[c] == kActive ? key_of(front_, c, rounds_ + 1) : 0;
  });
  for_each(count, kCornerGrain, [&](std::size_t i) {
    const std::uint32_t c = front_.alive[i];
    const std::uint32_t before = front_.previous[c], after = front_.next[c];
    const std::uint64_t key = keys_[c];
    chosen_[i] = key > 0 && key >= keys_[before] && key >= keys_[after] &&
                 key >= keys_[front_.previous[before]] && key >= keys_[front_.next[after]];
  });
  active_.clear();
  for (std::size_t i = 0; i < count; ++i)
    if (chosen_[i]) active_.push_back(front_.alive[i]);
  return !active_.empty();
}

/// Leaves in `active_` the corners that hold every cell that they claim.
void FrontRounds::claim() {
  for_each(active_.size(), kCornerGrain, [&](std::size_t i) {
    const std::uint64_t key = keys_[active_[i]];
    for_cells(field_, claimed_cells(field_, front_, active_[i]), [&](std::size_t cell) {
      std::atomic_ref<std::uint64_t> held(claims_[cell]);
      std::uint64_t old = held.load(std::memory_order_relaxed);
      while (old < key && !held.compare_exchange_weak(old, key, std::memory_order_relaxed)) {
      }
    });
  });
  chosen_.resize(active_.size());
  for_each(active_.size(), kCornerGrain, [&](std::size_t i) {
    bool holds = true;
    for_cells(field_, claimed_cells(field_, front_, active_[i]),
              [&](std::size_t cell) { holds = holds && claims_[cell] == keys_[active_[i]]; });
    chosen_[i] = holds;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < active_.size(); ++i)
    if (chosen_[i]) active_[kept++] = active_[i];
  active_.resize(kept);
}

void FrontRounds::ask(const FrontLimits& limits) {
  proposals_.resize(active_.size());
  const std::size_t count = active_.size();
  backend_.run((count + kProposalGrain - 1) / kProposalGrain, [&](std::size_t task) {
    ProposalScratch scratch;
    const std::size_t end = std::min((task + 1) * kProposalGrain, count);
    for (std::size_t i = task * kProposalGrain; i < end; ++i)
      proposals_[i] = propose(field_, sizes_, front_, grid_, vertices_, limits,
                              claimed_cells(field_, front_, active_[i]), active_[i], scratch);
  });
}

/// Corners without a proposal rest until their links change; those that lacked room get more.
void FrontRounds::settle_failed() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < proposals_.size(); ++i) {
    const std::uint32_t corner = active_[i];
    if (proposals_[i].kind == Proposal::nothing ||
        (proposals_[i].kind == Proposal::more_room && front_.wide[corner])) {
      front_.state[corner] = kFrozen;
    } else if (proposals_[i].kind == Proposal::more_room) {
      front_.wide[corner] = 1;
    } else {
      if (kept != i) proposals_[kept] = proposals_[i];
      ++kept;
    }
  }
  proposals_.resize(kept);
}

/// Gives every proposal its places behind what there is.
void FrontRounds::number() {
  Start start = {static_cast<std::uint32_t>(front_.position.size()),
                 static_cast<std::uint32_t>(front_.triangles.size()),
                 static_cast<std::uint32_t>(front_.vertex.size())};
  starts_.clear();
  for (const Proposal& proposal : proposals_) {
    starts_.push_back(start);
    const Needs needs = needs_of(front_, proposal);
    start.vertex += needs.vertices;
    start.triangle += 3 * needs.triangles;
    start.corner += needs.corners;
  }
  const auto old = static_cast<std::uint32_t>(front_.vertex.size());
  front_.resize_vertices(start.vertex);
  front_.triangles.resize(start.triangle);
  front_.resize_corners(start.corner);
  for (std::uint32_t c = old; c < start.corner; ++c) front_.alive.push_back(c);
}

void FrontRounds::add() {
  for_each(proposals_.size(), kProposalGrain, [&](std::size_t i) { add_one(i); });
}

void FrontRounds::add_one(std::size_t i) {
  const Proposal& p = proposals_[i];
  const Start start = starts_[i];
  const std::uint32_t c = p.corner, next = front_.next[c], previous = front_.previous[c];
  std::uint32_t* triangle = &front_.triangles[start.triangle];
  switch (p.kind) {
    case Proposal::ear:
      fill_edge(front_, previous, next, kNone, triangle);
      return;
    case Proposal::join_next:
      fill_edge(front_, c, p.target, start.corner, triangle);
      return;
    case Proposal::join_previous:
      fill_edge(front_, previous, p.target, start.corner, triangle);
      return;
    case Proposal::join_both:
      fill_edge(front_, c, p.target, start.corner, triangle);
      fill_edge(front_, previous, p.target, kNone, triangle + 3);
      return;
    default:
      break;
  }
  std::uint32_t last = next;  // the corner that the fan has come to
  for (std::uint32_t k = 0; k <= p.vertices; ++k) {
    std::uint32_t here = previous;
    if (k < p.vertices) {
      here = start.corner + k;
      front_.vertex[here] = start.vertex + k;
      front_.position[start.vertex + k] = p.position[k];
      front_.normal[start.vertex + k] = p.normal[k];
      front_.size[start.vertex + k] = p.size[k];
      front_.corners[start.vertex + k] = 1;
    }
    triangle[3 * k] = front_.vertex[c];
    triangle[3 * k + 1] = front_.vertex[here];
    triangle[3 * k + 2] = front_.vertex[last];
    front_.link(here, last);
    last = here;
  }
  front_.kill(c);
}

void FrontRounds::drop_dead() {
  std::erase_if(front_.alive, [&](std::uint32_t c) { return front_.state[c] == kDead; });
}

}  // namespace vasamesh

/// Rounds of mesh expanding: corners of the boundary in blocks, a proposal's pieces in tasks.

#include <cstdint>
#include <vector>

#include "backend/ranges.h"
#include "stages/expand_propose.h"
#include "stages/expand_steps.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kCornerGrain = 512;   // corners a task of the light steps takes
constexpr std::size_t kProposalGrain = 16;  // proposals a task takes
constexpr std::size_t kNearUsual = 128;     // edges near a corner, hardly ever more

enum Mark : std::uint8_t { kDropped, kKept, kChosen };

Mark mark_of(const FrontView& front, std::uint32_t corner) {
  if (front.corners[corner].state == CornerState::dead) return kDropped;
  list_edge(front, corner);
  return goes_first(front, corner) ? kChosen : kKept;
}

/// What a corner that holds its claim proposes, and what becomes of one that proposes nothing.
Proposal asked(const FieldView& field, const SizeView& sizes, const FrontLimits& limits,
               const FrontView& front, std::uint32_t corner, std::vector<BoundaryEdge>& near) {
  FrontCorner& c = front.corners[corner];
  const CellBox claimed = claimed_cells(field, front, corner);
  const Proposal proposal = propose(field, sizes, front, limits, claimed, corner, near);
  const bool more_room = proposal.kind == Proposal::more_room;
  if (proposal.kind == Proposal::nothing || (more_room && c.wide)) c.state = CornerState::frozen;
  if (more_room) c.wide = 1;
  return proposal;
}

}  // namespace

void TbbBackend::expand_choose(const FieldView& field, std::uint32_t round, bool wake,
                               const FrontView& front) {
  FrontCounts& counts = front.counts[0];
  const std::size_t count = counts.listed;
  for_each(count, kCornerGrain,
           [&](std::size_t i) { measure_corner(field, front, round, wake, front.listed[i]); });
  std::vector<Mark> marks(count);
  for_each(count, kCornerGrain, [&](std::size_t i) { marks[i] = mark_of(front, front.listed[i]); });
  // On one thread: it is less than what the start of tasks takes.
  std::uint32_t alive = 0, chosen = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (marks[i] != kDropped) front.alive[alive++] = front.listed[i];
    if (marks[i] == kChosen) front.chosen[chosen++] = front.listed[i];
  }
  counts.alive = alive;
  counts.chosen = chosen;
}

void TbbBackend::expand_claim(const FieldView& field, const FrontView& front) {
  for_each(front.proposals.size, kProposalGrain,
           [&](std::size_t i) { claim_cells(field, front, front.chosen[i]); });
}

void TbbBackend::expand_propose(const FieldView& field, const SizeView& sizes,
                                const FrontLimits& limits, const FrontView& front) {
  const auto propose_range = [&](std::size_t begin, std::size_t end) {
    std::vector<BoundaryEdge> near;
    near.reserve(kNearUsual);
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t corner = front.chosen[i];
      front.proposals[i].kind = Proposal::nothing;
      if (holds_cells(field, front, corner))
        front.proposals[i] = asked(field, sizes, limits, front, corner, near);
      front.starts[i] = needs_of(front, corner, front.proposals[i]);
    }
  };
  for_each_range(*this, front.proposals.size, kProposalGrain, propose_range);
}

void TbbBackend::expand_add(const FieldView& field, const FrontView& front) {
  FrontCounts& counts = front.counts[0];
  counts.listed = counts.alive;
  for (std::size_t i = 0; i < front.starts.size; ++i) {
    const FrontStart needs = front.starts[i];
    front.starts[i] = {counts.vertices, counts.triangles, counts.corners};
    counts.vertices += needs.vertex;
    counts.triangles += needs.triangle;
    counts.corners += needs.corner;
    counts.listed += needs.corner;
  }
  for_each(front.proposals.size, kProposalGrain,
           [&](std::size_t i) { add_proposal(field, front, i); });
}

}  // namespace vasamesh

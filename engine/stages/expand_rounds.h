#pragma once

/// \file
/// The rounds of mesh expanding: who may propose, and what is added.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/expand_front.h"
#include "stages/expand_grid.h"
#include "stages/expand_propose.h"

namespace vasamesh {

class FrontRounds {
 public:
  FrontRounds(Backend& backend, const FieldView& field, const SizeView& sizes, Front& front,
              std::size_t most_triangles);

  /// Rounds until no corner has anything to propose. \return false when the budget is spent.
  bool run(const FrontLimits& limits);

  int count() const { return rounds_; }

 private:
  void measure_angles();
  bool choose();
  void claim();
  void ask(const FrontLimits& limits);
  void settle_failed();
  void number();
  void add();
  void add_one(std::size_t i);
  void drop_dead();

  /// body(i) for i in 0 .. count - 1, in tasks.
  template <class Body>
  void for_each(std::size_t count, std::size_t grain, const Body& body) {
    backend_.run((count + grain - 1) / grain, [&](std::size_t task) {
      const std::size_t end = std::min((task + 1) * grain, count);
      for (std::size_t i = task * grain; i < end; ++i) body(i);
    });
  }

  Backend& backend_;
  const FieldView field_;
  const SizeView sizes_;
  Front& front_;
  EdgeGrid grid_;
  VertexGrid vertices_;
  const std::size_t most_triangles_;
  int rounds_ = 0;

  /// Where the new parts of a proposal begin.
  struct Start {
    std::uint32_t vertex, triangle, corner;
  };

  std::vector<std::uint64_t> claims_;  ///< a cell: the highest key that claimed it, ever
  std::vector<std::uint64_t> keys_;    ///< a corner: its key of this round
  std::vector<std::uint32_t> active_;  ///< corners that may propose, then those that do
  std::vector<std::uint8_t> chosen_;
  std::vector<Proposal> proposals_;
  std::vector<Start> starts_;
};

}  // namespace vasamesh

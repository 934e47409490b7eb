#pragma once

/// \file
/// The rounds of mesh expanding: who may propose, and what is added.

#include <cstddef>

#include "backend/backend.h"
#include "stages/expand_front.h"
#include "types/front.h"
#include "types/sizes.h"

namespace vasamesh {

class FrontRounds {
 public:
  FrontRounds(Backend& backend, const FieldView& field, const SizeView& sizes, Front& front,
              std::size_t most_triangles)
      : backend_(backend),
        field_(field),
        sizes_(sizes),
        front_(front),
        most_triangles_(most_triangles) {}

  /// Rounds until no corner has anything to propose. \param wake  corners that had nothing are
  /// asked again. \return false when the budget of triangles or of rounds is spent.
  bool run(const FrontLimits& limits, bool wake = false);

  int count() const { return rounds_; }

 private:
  Backend& backend_;
  const FieldView field_;
  const SizeView sizes_;
  Front& front_;
  const std::size_t most_triangles_;
  int rounds_ = 0;
};

}  // namespace vasamesh

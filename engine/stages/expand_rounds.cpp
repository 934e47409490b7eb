#include "stages/expand_rounds.h"

#include <cstdint>

#include "stages/expand_steps.h"

namespace vasamesh {

bool FrontRounds::run(const FrontLimits& limits, bool wake) {
  for (; rounds_ + 1 < static_cast<int>(kRoundsEnd); wake = false) {
    backend_.expand_choose(field_, static_cast<std::uint32_t>(rounds_ + 1), wake, front_.view());
    front_.begin_round();
    if (front_.counts().triangles > most_triangles_) return false;
    if (front_.counts().chosen == 0) return true;
    ++rounds_;
    const FrontView front = front_.view();
    backend_.expand_claim(field_, front);
    backend_.expand_propose(field_, sizes_, limits, front);
    backend_.expand_add(field_, front);
  }
  return true;
}

}  // namespace vasamesh

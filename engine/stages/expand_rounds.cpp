#include "stages/expand_rounds.h"

#include <algorithm>
#include <cstdint>

#include "stages/expand_steps.h"

namespace vasamesh {

namespace {

constexpr int kLastRound = 1000;  // none begins: a front that has not ended by then runs away
static_assert(kLastRound < static_cast<int>(kRoundsEnd));

}  // namespace

bool FrontRounds::run(const FrontLimits& limits, bool wake) {
  for (;; wake = false) {
    const int round = std::min(rounds_ + 1, kLastRound);
    backend_.expand_choose(field_, static_cast<std::uint32_t>(round), wake, front_.view());
    front_.begin_round();
    if (front_.counts().triangles > most_triangles_ || round == kLastRound) return false;
    if (front_.counts().chosen == 0) return true;
    rounds_ = round;
    const FrontView front = front_.view();
    backend_.expand_claim(field_, front);
    backend_.expand_propose(field_, sizes_, limits, front);
    backend_.expand_add(field_, front);
  }
}

}  // namespace vasamesh

#include "stages/expand_grid.h"

#include <algorithm>

namespace vasamesh {

void EdgeGrid::build(Backend& backend, const Front& front) {
  constexpr std::size_t kGrain = 512;
  for (const std::uint32_t cell : cell_) head_[cell] = kNone;
  const std::size_t count = front.alive.size();
  cell_.resize(count);
  next_.resize(count);
  edges_.resize(count);
  backend.run((count + kGrain - 1) / kGrain, [&](std::size_t task) {
    const std::size_t end = std::min((task + 1) * kGrain, count);
    for (std::size_t i = task * kGrain; i < end; ++i) {
      const std::uint32_t corner = front.alive[i];
      edges_[i] = {front.at(corner), front.at(front.next[corner]), front.normal_at(corner), corner};
      const Vec3 middle = 0.5f * (edges_[i].start + edges_[i].end);
      cell_[i] = static_cast<std::uint32_t>(cell_index(field_, cell_at(field_, middle)));
    }
  });
  for (std::uint32_t i = 0; i < count; ++i) {
    next_[i] = head_[cell_[i]];
    head_[cell_[i]] = i;
  }
}

}  // namespace vasamesh

#include "stages/expand_grid.h"

#include <algorithm>

namespace vasamesh {

void EdgeGrid::build(Backend& backend, const Front& front) {
  constexpr std::size_t kGrain = 1024;
  const std::size_t count = front.alive.size(), tasks = (count + kGrain - 1) / kGrain;
  cell_.resize(count);
  place_.resize(count);
  edges_.resize(count);
  const auto for_alive = [&](const auto& body) {
    backend.run(tasks, [&](std::size_t task) {
      const std::size_t end = std::min((task + 1) * kGrain, count);
      for (std::size_t i = task * kGrain; i < end; ++i) body(i, front.alive[i]);
    });
  };
  for_alive([&](std::size_t i, std::uint32_t corner) {
    const Vec3 middle = 0.5f * (front.at(corner) + front.at(front.next[corner]));
    cell_[i] = static_cast<std::uint32_t>(cell_index(field_, cell_at(field_, middle)));
  });
  // A counting sort: entry cell + 1 runs from the cell's first edge to its end.
  std::fill(first_.begin(), first_.end(), 0u);
  for (const std::uint32_t cell : cell_) ++first_[cell + 1];
  for (std::size_t cell = 1; cell < first_.size(); ++cell) first_[cell] += first_[cell - 1];
  for (std::size_t i = 0; i < count; ++i) place_[i] = first_[cell_[i]]++;
  for (std::size_t cell = first_.size() - 1; cell > 0; --cell) first_[cell] = first_[cell - 1];
  first_[0] = 0;
  for_alive([&](std::size_t i, std::uint32_t corner) {
    edges_[place_[i]] = {front.at(corner), front.at(front.next[corner]), front.normal_at(corner),
                         corner};
  });
}

}  // namespace vasamesh

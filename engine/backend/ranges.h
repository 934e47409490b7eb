#pragma once

/// \file
/// Host work over the indices 0 .. count - 1 in ranges of `grain`, the last of which may be
/// shorter: each is a task of Backend::run. What they give is put together in their order, so that
/// results depend on sizes alone.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "backend/backend.h"
#include "backend/in_steps.h"

namespace vasamesh {

/// body(begin, end) for each range begin .. end - 1, which is number begin / grain.
template <class Body>
void for_each_range(Backend& backend, std::size_t count, std::size_t grain, const Body& body) {
  backend.run((count + grain - 1) / grain, [&](std::size_t task) {
    const std::size_t begin = task * grain;
    body(begin, std::min(begin + grain, count));
  });
}

/// body(i) for each index.
template <class Body>
void for_each_index(Backend& backend, std::size_t count, std::size_t grain, const Body& body) {
  for_each_range(backend, count, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// \return map(begin, end) of each range, in order.
template <class Map>
auto map_ranges(Backend& backend, std::size_t count, std::size_t grain, const Map& map) {
  using Mapped = std::invoke_result_t<const Map&, std::size_t, std::size_t>;
  static_assert(!std::is_same_v<Mapped, bool>, "tasks write the bits of one word");
  std::vector<Mapped> results((count + grain - 1) / grain);
  for_each_range(backend, count, grain, [&](std::size_t begin, std::size_t end) {
    results[begin / grain] = map(begin, end);
  });
  return results;
}

/// Combines map(begin, end) of all ranges, one after the other: result = combine(result, mapped),
/// from `initial` on; by default their sum.
template <class T, class Map, class Combine = std::plus<>>
T reduce_ranges(Backend& backend, std::size_t count, std::size_t grain, T initial, const Map& map,
                const Combine& combine = {}) {
  T result = std::move(initial);
  for (auto& mapped : map_ranges(backend, count, grain, map))
    result = combine(std::move(result), std::move(mapped));
  return result;
}

/// \return what find(begin, end, found) appends to `found`, a vector of T, in the order of ranges.
template <class T, class Find>
std::vector<T> collect(Backend& backend, std::size_t count, std::size_t grain, const Find& find) {
  const auto parts = map_ranges(backend, count, grain, [&](std::size_t begin, std::size_t end) {
    std::vector<T> found;
    find(begin, end, found);
    return found;
  });
  std::size_t size = 0;
  for (const std::vector<T>& part : parts) size += part.size();
  std::vector<T> all;
  all.reserve(size);
  for (const std::vector<T>& part : parts) append_in_steps<T>(backend, part, all);
  return all;
}

}  // namespace vasamesh

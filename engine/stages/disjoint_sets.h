#pragma once

/// \file
/// Sets of the numbers 0 .. count - 1 that are united pair by pair. The root of a set is its lowest
/// member, so that nothing depends on the order of the unions.
///
/// Galler, Fischer: An improved equivalence algorithm, 1964.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vasamesh {

class DisjointSets {
 public:
  /// Each number in a set of its own.
  explicit DisjointSets(std::size_t count) : parent_(count) {
    for (std::size_t i = 0; i < count; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  /// The root of each number.
  std::vector<std::uint32_t> roots() && {
    for (std::uint32_t& parent : parent_) parent = parent_[parent];
    return std::move(parent_);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace vasamesh

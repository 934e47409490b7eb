#pragma once

/// \file
/// Sets of the numbers 0 .. count - 1 that are united pair by pair, also by many threads at the
/// same time. The root of a set is its lowest member, so that nothing depends on the order of the
/// unions.
///
/// Galler, Fischer: An improved equivalence algorithm, 1964; Anderson, Woll: Wait-free parallel
/// algorithms for the union-find problem, 1991.

#include <algorithm>
#include <atomic>
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

  /// May be out of date as soon as it is there where other threads unite sets.
  std::uint32_t root(std::uint32_t i) {
    for (;;) {
      const std::uint32_t parent = at(i).load(std::memory_order_relaxed);
      if (parent == i) return i;
      const std::uint32_t above = at(parent).load(std::memory_order_relaxed);
      at(i).store(above, std::memory_order_relaxed);  // not a root, and never one again
      i = above;
    }
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      std::uint32_t upper = std::max(a, b);
      if (at(upper).compare_exchange_weak(upper, std::min(a, b), std::memory_order_relaxed)) return;
    }
  }

  /// The root of each number, when all are united.
  std::vector<std::uint32_t> roots() && {
    for (std::uint32_t& parent : parent_) parent = parent_[parent];
    return std::move(parent_);
  }

 private:
  std::atomic_ref<std::uint32_t> at(std::uint32_t i) { return std::atomic_ref(parent_[i]); }

  std::vector<std::uint32_t> parent_;
};

}  // namespace vasamesh

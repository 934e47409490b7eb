/// \file
/// Sets united by many threads at the same time are those that one thread finds.

#include "stages/disjoint_sets.h"

#include <gtest/gtest.h>

#include <random>

#include "tbb/backend.h"

namespace vasamesh {
namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs random_pairs(std::uint32_t count, std::size_t pairs, unsigned seed) {
  std::mt19937 random(seed);
  Pairs result(pairs);
  for (auto& [a, b] : result) {
    a = random() % count;
    b = random() % count;
  }
  return result;
}

/// The lowest number that each hangs together with: labels lowered until none changes.
std::vector<std::uint32_t> roots_plainly(std::uint32_t count, const Pairs& pairs) {
  std::vector<std::uint32_t> label(count);
  for (std::uint32_t i = 0; i < count; ++i) label[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : pairs) {
      const std::uint32_t least = std::min(label[a], label[b]);
      changed = changed || label[a] != least || label[b] != least;
      label[a] = label[b] = least;
    }
  }
  return label;
}

TEST(DisjointSets, OfNothing) { EXPECT_TRUE(DisjointSets(0).roots().empty()); }

TEST(DisjointSets, UnitedByManyThreads) {
  constexpr std::uint32_t kCount = 20000;
  for (const std::size_t pair_count : {5000u, 12000u, 60000u}) {
    const Pairs pairs = random_pairs(kCount, pair_count, 7);
    const std::vector<std::uint32_t> want = roots_plainly(kCount, pairs);
    for (const int threads : {1, 2, 8}) {
      DisjointSets sets(kCount);
      make_tbb_backend(threads, nullptr)->run(pair_count, [&](std::size_t i) {
        sets.unite(pairs[i].first, pairs[i].second);
      });
      EXPECT_EQ(std::move(sets).roots(), want) << pair_count << " pairs, " << threads;
    }
  }
}

}  // namespace
}  // namespace vasamesh

/// \file
/// Rows of bits against a byte a voxel: every length of a row and every cut into runs, also from
/// several threads at once.

#include "io/bit_rows.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

namespace vasamesh {
namespace {

using Mask = std::vector<std::uint8_t>;

/// Mostly background in long runs, as vessels are, with noise between.
Mask vessel_like_mask(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  Mask mask(count, 0);
  for (std::size_t i = 0; i < count; i += 1 + random() % 300)
    for (std::size_t k = i; k < std::min(count, i + random() % 40); ++k) mask[k] = random() % 4 > 0;
  return mask;
}

Mask packed_plainly(const Mask& mask, std::size_t length) {
  const std::size_t row_bytes = bit_row_bytes(length);
  Mask bits(mask.size() / length * row_bytes, 0);
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i])
      bits[i / length * row_bytes + i % length / 8] |=
          static_cast<std::uint8_t>(1u << (i % length % 8));
  return bits;
}

bool set_run(BitRows& rows, const Mask& mask, std::size_t first, std::size_t count) {
  return rows.set(first, count, [&](std::size_t i) { return mask[first + i] != 0; });
}

class RowLengths : public ::testing::TestWithParam<std::size_t> {};

TEST_P(RowLengths, RunsOfAnyLengthFillTheSameBits) {
  const std::size_t length = GetParam(), rows_count = 2000 / length + 3;
  const Mask mask = vessel_like_mask(length * rows_count, 5);
  std::mt19937 random(7);
  for (const std::size_t longest : {1u, 9u, 130u, 100000u}) {
    BitRows rows(length, rows_count);
    for (std::size_t first = 0, count = 0; first < mask.size(); first += count) {
      count = std::min(mask.size() - first, 1 + random() % longest);
      const bool any = std::find(mask.begin() + static_cast<std::ptrdiff_t>(first),
                                 mask.begin() + static_cast<std::ptrdiff_t>(first + count),
                                 1) != mask.begin() + static_cast<std::ptrdiff_t>(first + count);
      EXPECT_EQ(set_run(rows, mask, first, count), any) << first << " " << count;
    }
    EXPECT_EQ(rows.take(), packed_plainly(mask, length)) << "runs of up to " << longest;
  }
}

INSTANTIATE_TEST_SUITE_P(BitRows, RowLengths,
                         ::testing::Values(1, 2, 7, 8, 9, 61, 63, 64, 65, 127, 128, 200, 1031));

TEST(BitRows, NeighboursInOneByteAreSetByDifferentThreads) {
  constexpr std::size_t kLength = 61, kRows = 4000, kThreads = 4;
  const Mask mask = vessel_like_mask(kLength * kRows, 3);
  BitRows rows(kLength, kRows);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < mask.size(); i += kThreads) set_run(rows, mask, i, 1);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(rows.take(), packed_plainly(mask, kLength));
}

}  // namespace
}  // namespace vasamesh

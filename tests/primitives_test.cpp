/// Fills, sums, scans and ranges of every backend against plain loops.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <numeric>
#include <random>

#include "backend/ranges.h"
#include "support/backend_test.h"
#include "support/brick_sets.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

/// 0, 1, powers of two and their neighbours, and sizes past every block of every backend.
const std::size_t kCounts[] = {0,    1,    2,    3,    7,     64,    65,    257,
                               1023, 1024, 1025, 5000, 16384, 16385, 100003};

class Primitives : public BackendTest {};

/// The contract's pairwise sum, by recursion from the top.
float pairwise(const std::vector<float>& values, std::size_t first, std::size_t step,
               std::size_t n) {
  if (n == 1) return first < values.size() ? values[first] : 0.0f;
  return pairwise(values, first, step * 2, n / 2) + pairwise(values, first + step, step * 2, n / 2);
}

float pairwise(const std::vector<float>& values) {
  if (values.empty()) return 0;
  std::size_t n = 1;
  while (n < values.size()) n *= 2;
  return pairwise(values, 0, 1, n);
}

std::vector<std::uint32_t> random_counts(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> values(count);
  for (std::uint32_t& value : values) value = random() % 5 == 0 ? 0 : random() % 1000;
  return values;
}

TEST_P(Primitives, FillWritesTheViewAlone) {
  Buffer<float> floats = to_backend(backend(), std::vector<float>(1000, 1.0f));
  Buffer<std::uint8_t> bytes = to_backend(backend(), std::vector<std::uint8_t>(1000, 1));
  Buffer<std::uint32_t> words = to_backend(backend(), std::vector<std::uint32_t>(1000, 1));
  backend().fill(floats.view().subview(3, 990), -2.5f);
  backend().fill(bytes.view().subview(3, 990), std::uint8_t{7});
  backend().fill(words.view().subview(3, 990), 0x01020304u);
  const auto got_floats = to_host(backend(), floats.view());
  const auto got_bytes = to_host(backend(), bytes.view());
  const auto got_words = to_host(backend(), words.view());
  for (std::size_t i = 0; i < 1000; ++i) {
    const bool inside = i >= 3 && i < 993;
    EXPECT_EQ(got_floats[i], inside ? -2.5f : 1.0f) << i;
    EXPECT_EQ(got_bytes[i], inside ? 7 : 1) << i;
    EXPECT_EQ(got_words[i], inside ? 0x01020304u : 1u) << i;
  }
}

TEST_P(Primitives, FillOfNothing) {
  backend().fill(View<float>{}, 1.0f);
  Buffer<float> one = to_backend(backend(), std::vector<float>{5.0f});
  backend().fill(one.view().subview(1, 0), 1.0f);
  EXPECT_EQ(to_host(backend(), one.view())[0], 5.0f);
}

TEST_P(Primitives, ReduceSumIsThePairwiseSum) {
  for (const std::size_t count : kCounts) {
    const std::vector<float> values = awkward_floats(count, static_cast<std::uint32_t>(count));
    Buffer<float> buffer = to_backend(backend(), values);
    const float got = backend().reduce_sum(buffer.view()), want = pairwise(values);
    EXPECT_EQ(std::memcmp(&got, &want, sizeof(float)), 0) << count << ": " << got << " " << want;
  }
}

TEST_P(Primitives, ReduceSumOfAView) {
  const std::vector<float> values = awkward_floats(3000, 5);
  Buffer<float> buffer = to_backend(backend(), values);
  const std::vector<float> part(values.begin() + 17, values.begin() + 17 + 2049);
  EXPECT_EQ(backend().reduce_sum(buffer.view().subview(17, 2049)), pairwise(part));
  EXPECT_EQ(to_host(backend(), buffer.view()), values) << "the values must stay as they are";
}

TEST_P(Primitives, ExclusiveScan) {
  for (const std::size_t count : kCounts) {
    const auto values = random_counts(count, static_cast<std::uint32_t>(count));
    std::vector<std::uint32_t> want(count + 1, 0);
    std::partial_sum(values.begin(), values.end(), want.begin() + 1);
    Buffer<std::uint32_t> in = to_backend(backend(), values);
    Buffer<std::uint32_t> out(backend(), count + 1);
    EXPECT_EQ(backend().exclusive_scan(in.view(), out.view()), want.back());
    EXPECT_EQ(to_host(backend(), out.view()), want) << count;
  }
}

TEST_P(Primitives, ExclusiveScanInPlaceAndInAView) {
  const auto values = random_counts(20011, 3);
  Buffer<std::uint32_t> buffer = to_backend(backend(), values);
  const View<std::uint32_t> view = buffer.view();
  backend().exclusive_scan(view.subview(5, 20000), view.subview(5, 20001));
  const auto got = to_host(backend(), buffer.view());
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 20000; ++i) {
    ASSERT_EQ(got[5 + i], sum) << i;
    sum += values[5 + i];
  }
  EXPECT_EQ(got[20005], sum);
  for (const std::size_t i : {0, 4, 20006, 20010}) EXPECT_EQ(got[i], values[i]) << i;
}

TEST_P(Primitives, ExclusiveScanUpToItsLimit) {
  std::vector<std::uint32_t> values(4001, 0);
  values[10] = 0x80000000u;
  values[3999] = 0x7fffffffu;
  Buffer<std::uint32_t> in = to_backend(backend(), values);
  Buffer<std::uint32_t> out(backend(), values.size() + 1);
  EXPECT_EQ(backend().exclusive_scan(in.view(), out.view()), 0xffffffffu);
  values[4000] = 1;
  backend().upload<std::uint32_t>(in.view(), values);
  try {
    backend().exclusive_scan(in.view(), out.view());
    FAIL() << "a sum of 2^32 must be refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::refused);
  }
}

TEST_P(Primitives, RangesCoverAllIndicesOnce) {
  constexpr std::size_t kGrain = 64;
  for (const std::size_t count : kCounts) {
    std::vector<int> by_range(count, 0), by_index(count, 0);
    for_each_range(backend(), count, kGrain, [&](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin % kGrain, 0u);
      EXPECT_EQ(end, std::min(begin + kGrain, count));
      for (std::size_t i = begin; i < end; ++i) ++by_range[i];
    });
    for_each_index(backend(), count, kGrain, [&](std::size_t i) { ++by_index[i]; });
    EXPECT_EQ(by_range, std::vector<int>(count, 1));
    EXPECT_EQ(by_index, std::vector<int>(count, 1));
  }
}

TEST_P(Primitives, RangesArePutTogetherInOrder) {
  constexpr std::size_t kGrain = 64;
  for (const std::size_t count : kCounts) {
    const std::vector<float> values = awkward_floats(count, static_cast<std::uint32_t>(count));
    const auto sum_of = [&](std::size_t begin, std::size_t end) {
      return std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(begin),
                             values.begin() + static_cast<std::ptrdiff_t>(end), 0.0f);
    };
    std::vector<float> sums, positive;
    float sum = 0;
    for (std::size_t i = 0; i < count; i += kGrain) {
      sums.push_back(sum_of(i, std::min(i + kGrain, count)));
      sum += sums.back();
    }
    std::copy_if(values.begin(), values.end(), std::back_inserter(positive),
                 [](float value) { return value > 0; });
    EXPECT_EQ(map_ranges(backend(), count, kGrain, sum_of), sums) << count;
    EXPECT_EQ(reduce_ranges(backend(), count, kGrain, 0.0f, sum_of), sum) << count;
    EXPECT_EQ(reduce_ranges(backend(), count, kGrain, -1.0f, sum_of,
                            [](float, float last) { return last; }),
              sums.empty() ? -1.0f : sums.back())
        << count;
    EXPECT_EQ(collect<float>(backend(), count, kGrain,
                             [&](std::size_t begin, std::size_t end, std::vector<float>& found) {
                               for (std::size_t i = begin; i < end; ++i)
                                 if (values[i] > 0) found.push_back(values[i]);
                             }),
              positive)
        << count;
  }
}

TEST_P(Primitives, MemoryIsCountedAndLimited) {
  const std::size_t before = backend().bytes_held();
  {
    Buffer<float> buffer(backend(), 1000);
    EXPECT_EQ(backend().bytes_held(), before + 4000);
    EXPECT_GE(backend().bytes_peak(), before + 4000);
  }
  EXPECT_EQ(backend().bytes_held(), before);
  backend().set_byte_limit(before + 5000);
  EXPECT_NO_THROW(Buffer<float>(backend(), 1250));
  try {
    Buffer<float>(backend(), 1251);
    FAIL() << "above the limit";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::refused);
    EXPECT_NE(std::string(error.what()).find("--max-memory"), std::string::npos) << error.what();
  }
  EXPECT_EQ(backend().bytes_held(), before);
}

TEST_P(Primitives, CopiesOfParts) {
  Buffer<float> buffer = to_backend(backend(), std::vector<float>(100, 0.0f));
  const std::vector<float> part{1, 2, 3};
  backend().upload<float>(buffer.view().subview(7, 3), part);
  std::vector<float> want(100, 0.0f);
  std::copy(part.begin(), part.end(), want.begin() + 7);
  EXPECT_EQ(to_host(backend(), buffer.view()), want);
  EXPECT_EQ(to_host(backend(), buffer.view().subview(8, 2)), (std::vector<float>{2, 3}));
}

INSTANTIATE_TEST_SUITE_P(Backends, Primitives, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh

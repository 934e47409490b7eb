/// What ThreadSanitizer reports of tasks: races between them, and nothing of what the loop orders.

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <numeric>
#include <thread>
#include <vector>

#include "tbb/backend.h"

namespace vasamesh {
namespace {

constexpr int kExitCode = 66;  // the sanitizer's, after a report

/// Two tasks, one a thread, that meet and then write the same place.
void race() {
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  std::atomic<int> arrived{0};
  std::size_t last = 0;
  make_tbb_backend(2, nullptr)->run(2, [&](std::size_t task) {
    arrived.fetch_add(1, std::memory_order_relaxed);
    while (arrived.load(std::memory_order_relaxed) < 2) std::this_thread::yield();
    last = task;
  });
  std::exit(last < 2 ? EXIT_SUCCESS : EXIT_FAILURE);
}

TEST(TaskOrderDeathTest, ARaceBetweenTasksIsReported) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(race(), testing::ExitedWithCode(kExitCode), "data race");
}

TEST(TaskOrder, ALoopOrdersItsTasksBeforeWhatFollows) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const auto backend = make_tbb_backend(4, nullptr);
  std::vector<std::size_t> values(1013), sums(values.size());
  for (std::size_t round = 1; round <= 20; ++round) {
    backend->run(values.size(), [&](std::size_t i) { values[i] = round * i; });
    backend->run(sums.size(),
                 [&](std::size_t i) { sums[i] = values[i] + values[values.size() - 1 - i]; });
    const std::size_t sum = std::accumulate(sums.begin(), sums.end(), std::size_t{0});
    EXPECT_EQ(sum, round * values.size() * (values.size() - 1));
  }
}

}  // namespace
}  // namespace vasamesh

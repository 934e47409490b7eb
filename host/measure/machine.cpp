#include "measure/machine.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <functional>
#include <thread>
#include <vector>

namespace vasamesh {
namespace {

constexpr std::size_t kElements = std::size_t{1} << 24;  // 64 MiB an array
constexpr std::size_t kLanes = 64, kRounds = 1 << 21;
constexpr int kRepeats = 7;

/// Processor time of the calling thread, seconds: other processes do not count.
double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// `work(thread)` on all threads at once: the slowest one's seconds in the best of the repeats.
double best_seconds(int threads, const std::function<void(int)>& work) {
  double best = 1e30;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    std::vector<double> seconds(static_cast<std::size_t>(threads));
    const auto timed = [&](int thread) {
      const double start = thread_seconds();
      work(thread);
      seconds[static_cast<std::size_t>(thread)] = thread_seconds() - start;
    };
    std::vector<std::thread> others;
    for (int t = 1; t < threads; ++t) others.emplace_back(timed, t);
    timed(0);
    for (std::thread& other : others) other.join();
    best = std::min(best, *std::max_element(seconds.begin(), seconds.end()));
  }
  return best;
}

/// Keeps the compiler from leaving out what makes the bytes at `result`.
void keep(const void* result) { asm volatile("" : : "r"(result) : "memory"); }

}  // namespace

double measure_bandwidth(int threads) {
  std::vector<float> a(kElements, 1.0f), b(kElements, 2.0f), c(kElements, 0.5f);
  const std::size_t part = kElements / static_cast<std::size_t>(threads);
  const double seconds = best_seconds(threads, [&](int thread) {
    const std::size_t first = part * static_cast<std::size_t>(thread);
    for (std::size_t i = first; i < first + part; ++i) a[i] = b[i] + 3.0f * c[i];
    keep(a.data());
  });
  return 12.0 * static_cast<double>(part) * threads / seconds;
}

double measure_arithmetic(int threads) {
  const double seconds = best_seconds(threads, [](int) {
    std::array<float, kLanes> x;
    x.fill(0.5f);
    for (std::size_t round = 0; round < kRounds; ++round)
      for (float& lane : x) lane = lane * 0.9f + 0.1f;
    keep(x.data());
  });
  return 2.0 * kLanes * kRounds * threads / seconds;
}

}  // namespace vasamesh

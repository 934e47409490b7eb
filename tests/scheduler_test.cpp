/// Whom the scheduler tells how far a conversion is.

#include "scheduler.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>

#include "vasamesh/host.h"

namespace vasamesh {
namespace {

TEST(Scheduler, TellsItsOwnThreadAloneWhileTasksRunLoopsOfTheirOwn) {
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  Context context = make_context({.backend = "tbb", .device = "", .threads = 2});
  std::mutex mutex;
  std::set<std::thread::id> told;
  context.progress = [&](std::string_view, double) {
    const std::lock_guard lock(mutex);
    told.insert(std::this_thread::get_id());
    return true;
  };
  Scheduler scheduler(context);
  scheduler.begin("points", Stage::points);
  const std::thread::id own = std::this_thread::get_id();
  std::atomic<int> arrived{0};
  scheduler.host().run(2, [&](std::size_t) {  // one task a thread
    for (++arrived; arrived < 2;) std::this_thread::yield();
    if (std::this_thread::get_id() == own) return;
    scheduler.host().run(
        100, [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
  });
  EXPECT_EQ(told, std::set{own});
}

}  // namespace
}  // namespace vasamesh

/// Whom the scheduler tells how far a conversion is.

#include "scheduler.h"

#include <gtest/gtest.h>

#include <set>
#include <string_view>
#include <thread>

#include "vasamesh/host.h"

namespace vasamesh {
namespace {

// Nothing was told yet, so that a checkpoint is late with it, whatever the clock says.
TEST(Scheduler, TellsItsOwnThreadAlone) {
  Context context = make_context({.backend = "tbb", .device = "", .threads = 2});
  std::multiset<std::thread::id> told;
  context.progress = [&](std::string_view, double) {
    told.insert(std::this_thread::get_id());
    return true;
  };
  Scheduler scheduler(context);
  std::thread([&] { scheduler.host().checkpoint(); }).join();
  EXPECT_TRUE(told.empty());
  scheduler.host().checkpoint();
  EXPECT_EQ(told, std::multiset{std::this_thread::get_id()});
}

}  // namespace
}  // namespace vasamesh

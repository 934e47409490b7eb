/// \file
/// Work on trial: what ends the copy does not end the program.

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/trial.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

constexpr std::int64_t kBytes = std::int64_t{1} << 28;

TEST(Trial, ChangesAreLost) {
  int value = 1;
  EXPECT_TRUE(survives(kBytes, [&] { value = 2; }));
  EXPECT_EQ(value, 1);
}

TEST(Trial, EndsThatAreSurvived) {
  EXPECT_FALSE(survives(kBytes, [] { std::abort(); }));
  EXPECT_FALSE(survives(kBytes, [] { std::raise(SIGKILL); }));
  EXPECT_FALSE(survives(kBytes, [] { throw std::length_error("x"); }));
}

TEST(Trial, AnInterruptIsNoFaultOfTheFile) {
  signal(SIGINT, SIG_DFL);  // a shell may have it ignored
  try {
    survives(kBytes, [] { std::raise(SIGINT); });
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

TEST(Trial, AnErrorComesThrough) {
  const std::string text(100'000, 'x');  // more than a pipe holds
  try {
    survives(kBytes, [&] { throw Error(ErrorCode::cancelled, text); });
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
    EXPECT_EQ(error.what(), text);
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Trial, MemoryIsBounded) {
  const auto take = [](std::int64_t bytes) {
    const std::vector<char> memory(static_cast<std::size_t>(bytes));
    EXPECT_EQ(memory.back(), 0);
  };
  EXPECT_TRUE(survives(kBytes, [&] { take(kBytes / 2); }));
  EXPECT_FALSE(survives(kBytes, [&] { take(2 * kBytes); }));
}

TEST(Trial, MemoryThatTheProcessLacksIsNoFault) {
  const auto take = [] { EXPECT_EQ(std::vector<char>(2 * kBytes).back(), 0); };
  const auto try_more_than_there_is = [&] {
    EXPECT_LT(memory_left(), 2 * kBytes);
    try {
      survives(4 * kBytes, take);
    } catch (const std::bad_alloc&) {
      return;
    }
    std::abort();
  };
  EXPECT_TRUE(survives(kBytes, try_more_than_there_is));
}
#endif

}  // namespace
}  // namespace vasamesh

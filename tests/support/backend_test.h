#pragma once

/// \file
/// One test body for every backend: a test suite derives from BackendTest, is instantiated over
/// backend_names(), and runs on each in turn.
///
///     class Sums : public BackendTest {};
///     TEST_P(Sums, OfNothing) { EXPECT_EQ(backend().reduce_sum({}), 0); }
///     INSTANTIATE_TEST_SUITE_P(Backends, Sums, ::testing::ValuesIn(backend_names()), test_name);

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "support/backends.h"

namespace vasamesh {

/// A name for INSTANTIATE_TEST_SUITE_P.
inline std::string test_name(const ::testing::TestParamInfo<std::string>& info) {
  return info.param;
}

/// Skips where the backend needs an OpenCL device and there is none; checks that the backend that
/// opened is the one that was asked for.
class BackendTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    backend_ = open_backend(GetParam());
    if (!backend_) GTEST_SKIP() << "no OpenCL device here";
    ASSERT_TRUE(GetParam().starts_with(backend_->name())) << backend_->name();
    ASSERT_FALSE(backend_->device().empty());
  }
  Backend& backend() { return *backend_; }
  const std::shared_ptr<Backend>& shared_backend() const { return backend_; }

 private:
  std::shared_ptr<Backend> backend_;
};

}  // namespace vasamesh

#pragma once

/// \file
/// A backend for what a test makes or asks beside the one that it is about.

#include "tbb/backend.h"

namespace vasamesh::test {

/// oneTBB with two threads.
inline Backend& host() {
  static const std::shared_ptr<Backend> tbb = make_tbb_backend(2, nullptr);
  return *tbb;
}

}  // namespace vasamesh::test

#pragma once

/// \file
/// The least of what many threads offer.

#include <atomic>
#include <cstdint>

namespace vasamesh {

/// Lowers an entry, which others may be lowering at the same time, to the value.
inline void lower_to(std::uint32_t& entry, std::uint32_t value) {
  std::atomic_ref<std::uint32_t> held(entry);
  std::uint32_t old = held.load(std::memory_order_relaxed);
  while (value < old && !held.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

}  // namespace vasamesh

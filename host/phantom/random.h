#pragma once

/// \file
/// A small random generator with the same numbers on every platform: SplitMix64 (Steele, Lea and
/// Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).

#include <cstdint>

namespace vasamesh::phantom {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Uniform in 0 .. count - 1; the bias is below count / 2^32.
  int below(int count) {
    return static_cast<int>(((next() >> 32) * static_cast<unsigned>(count)) >> 32);
  }

 private:
  std::uint64_t state_;
};

}  // namespace vasamesh::phantom

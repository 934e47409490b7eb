#pragma once

/// \file
/// Rows of eight bytes (states, labels or marks of nodes) as bits, and back.

#include <bit>
#include <cstdint>
#include <cstring>

#include "types/row_bits.h"

namespace vasamesh {

inline constexpr int kBrickRows = 64;

/// Row r of a brick's bytes: those of y = r & 7, z = r >> 3, x from the lowest byte on.
inline std::uint64_t load_bytes(const std::uint8_t* brick, int row = 0) {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, brick + 8 * row, sizeof(bytes));
  return bytes;
}

/// Bit x where byte x of a row has `bit`, a power of two.
constexpr std::uint32_t byte_bits(std::uint64_t bytes, std::uint8_t bit) {
  return gather_bits(bytes / bit);
}

/// Byte x is 1 where bit x of eight is set, else 0.
constexpr std::uint64_t bit_bytes(std::uint32_t bits) {
  const std::uint64_t places = bits * 0x0101010101010101u & 0x8040201008040201u;
  return (places + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u;
}

/// visit(x) for the bits that are set, from the lowest on.
template <class Visit>
void for_each_bit(std::uint32_t bits, const Visit& visit) {
  for (; bits; bits &= bits - 1) visit(std::countr_zero(bits));
}

}  // namespace vasamesh

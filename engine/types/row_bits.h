#pragma once

/// \file
/// Rows of bits in 64-bit words, least significant first, some bits of them at a time.

#include <cstdint>

namespace vasamesh {

/// Bit i is the lowest bit of byte i.
constexpr std::uint32_t gather_bits(std::uint64_t bytes) {
  return static_cast<std::uint32_t>((bytes & 0x0101010101010101u) * 0x0102040810204080u >> 56);
}

/// Bits first .. first + span - 1 of a row; all of them in it or in words after it. \pre span
/// <= 32.
inline std::uint32_t row_bits(const std::uint64_t* row, int first, int span) {
  const int word = first >> 6, shift = first & 63;
  std::uint64_t bits = row[word] >> shift;
  if (shift + span > 64) bits |= row[word + 1] << (64 - shift);
  return static_cast<std::uint32_t>(bits & ((std::uint64_t{1} << span) - 1));
}

/// The same of a row of so many words, with zeros before and after it. \pre first >= -64.
inline std::uint32_t row_bits(const std::uint64_t* row, int words, int first, int span) {
  const int word = first >> 6, shift = first & 63;
  std::uint64_t bits = 0;
  if (word >= 0 && word < words) bits = row[word] >> shift;
  if (shift + span > 64 && word + 1 < words) bits |= row[word + 1] << (64 - shift);
  return static_cast<std::uint32_t>(bits & ((std::uint64_t{1} << span) - 1));
}

}  // namespace vasamesh

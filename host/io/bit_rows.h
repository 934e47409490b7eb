#pragma once

/// \file
/// Rows of voxels as bits, least significant first, each row padded to a whole byte
/// (VoxelFormat::bits).

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vasamesh {

/// Bytes of a row of `length` voxels.
inline std::size_t bit_row_bytes(std::size_t length) { return (length + 7) / 8; }

/// Bits that are set run by run. Several threads may set different voxels at the same time.
class BitRows {
 public:
  /// All clear. \pre length > 0.
  BitRows(std::size_t length, std::size_t rows)
      : length_(length), bits_(bit_row_bytes(length) * rows) {}

  /// Sets voxel first + i where is_object(i), for i below `count`; rows follow one another.
  /// \return whether any was set.
  template <class IsObject>
  bool set(std::size_t first, std::size_t count, const IsObject& is_object) {
    bool any = false;
    for (std::size_t done = 0; done < count;) {
      const std::size_t x = (first + done) % length_, row = (first + done) / length_;
      const std::size_t run = std::min(length_ - x, count - done);
      any |= set_in_row(bits_.data() + row * bit_row_bytes(length_), x, run,
                        [&](std::size_t i) { return is_object(done + i); });
      done += run;
    }
    return any;
  }

  std::vector<std::uint8_t> take() { return std::move(bits_); }

 private:
  static constexpr std::size_t kBlock = 64;  // voxels looked at together: most are background

  template <class IsObject>
  static bool set_in_row(std::uint8_t* row, std::size_t x, std::size_t run,
                         const IsObject& is_object) {
    bool any = false;
    for (std::size_t done = 0; done < run;) {
      const std::size_t bit = (x + done) % 8;
      if (bit == 0 && done + kBlock <= run && is_clear(done, is_object)) {
        done += kBlock;
        continue;
      }
      const std::size_t count = std::min(8 - bit, run - done);
      unsigned bits = 0;
      for (std::size_t i = 0; i < count; ++i) bits |= unsigned{is_object(done + i)} << (bit + i);
      if (bits) put(row[(x + done) / 8], static_cast<std::uint8_t>(bits), count == 8);
      any |= bits != 0;
      done += count;
    }
    return any;
  }

  template <class IsObject>
  static bool is_clear(std::size_t first, const IsObject& is_object) {
    std::uint8_t any = 0;  // compilers do several bytes at once, but no bool
    for (std::size_t i = 0; i < kBlock; ++i) any |= is_object(first + i) ? 1 : 0;
    return any == 0;
  }

  /// A part of a byte may be beside another thread's.
  static void put(std::uint8_t& byte, std::uint8_t bits, bool whole) {
    if (whole)
      byte = bits;
    else
      std::atomic_ref(byte).fetch_or(bits, std::memory_order_relaxed);
  }

  std::size_t length_;
  std::vector<std::uint8_t> bits_;
};

}  // namespace vasamesh

#pragma once

/// \file
/// The segmentation, bit-packed and padded by background.

#include <array>
#include <cstdint>

#include "types/buffer.h"

namespace vasamesh {

/// Background voxels put before and, at least, after the volume along each axis, so that vessels
/// cut by the border are capped and no pass needs a bounds test. One brick.
inline constexpr int kPad = 8;

/// Bits of a padded volume, read only. `size` holds the padded voxels along each axis, multiples
/// of 8; a row of x is `words_per_row` 64-bit words, least significant bit first, bits past the
/// row zero. Voxel (x, y, z) of the padded volume is voxel (x - kPad, ...) of the caller's.
struct BitView {
  std::array<int, 3> size{0, 0, 0};
  int words_per_row = 0;
  View<const std::uint64_t> words;

  std::size_t word_count() const {
    return static_cast<std::size_t>(words_per_row) * size[1] * size[2];
  }
  std::size_t row(int y, int z) const {
    return (static_cast<std::size_t>(z) * size[1] + y) * words_per_row;
  }
  /// Host memory only; (x, y, z) inside the padded volume.
  bool test(int x, int y, int z) const { return (words[row(y, z) + (x >> 6)] >> (x & 63)) & 1u; }
};

/// Owner of the bits.
struct BitVolume {
  std::array<int, 3> size{0, 0, 0};
  int words_per_row = 0;
  Buffer<std::uint64_t> words;

  BitView view() const { return {size, words_per_row, words.view()}; }
};

}  // namespace vasamesh

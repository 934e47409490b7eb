#pragma once

/// \file
/// A small volume with a byte a voxel, for oracles and hand-made shapes.

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "backend/backend.h"
#include "types/volume.h"
#include "vasamesh/types.h"

namespace vasamesh::test {

struct DenseVolume {
  std::array<int, 3> size{0, 0, 0};
  std::vector<std::uint8_t> voxels;

  explicit DenseVolume(const std::array<int, 3>& dimensions)
      : size(dimensions),
        voxels(static_cast<std::size_t>(dimensions[0]) * dimensions[1] * dimensions[2], 0) {}

  std::uint8_t& at(int x, int y, int z) { return voxels[index(x, y, z)]; }
  /// Background outside the volume.
  bool object(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2] &&
           voxels[index(x, y, z)] != 0;
  }
  /// Fills first .. last, inclusive.
  DenseVolume& box(const std::array<int, 3>& first, const std::array<int, 3>& last,
                   bool value = true) {
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) at(x, y, z) = value;
    return *this;
  }

  std::array<std::int64_t, 3> size64() const { return {size[0], size[1], size[2]}; }

  VolumeView view() const {
    VolumeView view;
    view.data = voxels.data();
    view.geometry.size = size64();
    return view;
  }

 private:
  std::size_t index(int x, int y, int z) const {
    return x + static_cast<std::size_t>(size[0]) * (y + static_cast<std::size_t>(size[1]) * z);
  }
};

/// Each voxel as a block of so many.
inline DenseVolume enlarged(const DenseVolume& small, const std::array<int, 3>& times) {
  DenseVolume large({small.size[0] * times[0], small.size[1] * times[1], small.size[2] * times[2]});
  for (int z = 0; z < large.size[2]; ++z)
    for (int y = 0; y < large.size[1]; ++y)
      for (int x = 0; x < large.size[0]; ++x)
        large.at(x, y, z) = small.object(x / times[0], y / times[1], z / times[2]);
  return large;
}

/// Each voxel is object with the given probability.
inline DenseVolume random_volume(const std::array<int, 3>& size, double density, unsigned seed) {
  DenseVolume volume(size);
  std::mt19937 random(seed);
  const auto limit = static_cast<std::uint32_t>(density * 4294967295.0);
  for (std::uint8_t& voxel : volume.voxels) voxel = random() < limit;
  return volume;
}

/// The volume's bits, padded by kPad and up to multiples of eight.
inline BitVolume pack_plainly(Backend& backend, const DenseVolume& volume) {
  BitVolume bits;
  for (int a = 0; a < 3; ++a) bits.size[a] = (volume.size[a] + 2 * kPad + 7) / 8 * 8;
  bits.words_per_row = (bits.size[0] + 63) / 64;
  bits.words = Buffer<std::uint64_t>(backend, bits.view().word_count());
  const std::span<std::uint64_t> words = backend.on_host(bits.words.view());
  std::fill(words.begin(), words.end(), 0);
  for (int z = 0; z < volume.size[2]; ++z)
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x)
        if (volume.object(x, y, z))
          words[bits.view().row(y + kPad, z + kPad) + (x + kPad) / 64] |= std::uint64_t{1}
                                                                          << ((x + kPad) % 64);
  return bits;
}

}  // namespace vasamesh::test

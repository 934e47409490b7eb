/// Packing of the volume, the top-hat and the brick marks: word-parallel passes over rows of bits.

#include <algorithm>
#include <cstring>
#include <vector>

#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

using Word = std::uint64_t;

constexpr std::size_t kRowGrain = 64;  // rows a task takes

/// Eight bytes as eight bits: bit i is set where byte i is not zero.
Word nonzero_bytes(Word bytes) {
  constexpr Word kLow = 0x7f7f7f7f7f7f7f7fu, kHigh = 0x8080808080808080u;
  const Word flags = (((bytes & kLow) + kLow) | bytes) & kHigh;
  return ((flags >> 7) * 0x0102040810204080u) >> 56;
}

/// Up to eight voxels from voxel x of a row, as bits.
Word eight_voxels(const unsigned char* row, VoxelFormat format, std::size_t x, std::size_t left) {
  if (format == VoxelFormat::bits) return row[x / 8] & (0xffu >> (8 - left));
  Word bytes = 0;
  std::memcpy(&bytes, row + x, left);
  return nonzero_bytes(bytes);
}

/// How many voxels from x on, in steps of 64 bytes, are background; most of a vessel volume is.
std::size_t empty_run(const unsigned char* row, std::size_t x, std::size_t size) {
  const std::size_t first = x;
  for (; x + 64 <= size; x += 64) {
    Word any = 0;
    for (std::size_t i = 0; i < 64; i += 8) {
      Word bytes;
      std::memcpy(&bytes, row + x + i, 8);
      any |= bytes;
    }
    if (any != 0) break;
  }
  return x - first;
}

/// Packs one row of the caller's voxels into the words, from bit kPad on.
void pack_row(const VolumeView& volume, std::size_t row, Word* out, int words) {
  std::fill_n(out, words, Word{0});
  const auto size = static_cast<std::size_t>(volume.geometry.size[0]);
  const bool bytes = volume.format == VoxelFormat::bytes;
  const auto* from =
      static_cast<const unsigned char*>(volume.data) + row * (bytes ? size : (size + 7) / 8);
  for (std::size_t x = 0; x < size; x += 8) {
    if (bytes && x % 64 == 0) x += empty_run(from, x, size);
    if (x >= size) break;
    const std::size_t left = size - x;
    const Word eight = left >= 8 ? eight_voxels(from, volume.format, x, 8)
                                 : eight_voxels(from, volume.format, x, left);
    const std::size_t bit = x + kPad;
    out[bit / 64] |= eight << (bit % 64);
  }
}

bool is_empty(const Word* row, int words) {
  Word any = 0;
  for (int w = 0; w < words; ++w) any |= row[w];
  return any == 0;
}

/// The word of a row moved by one voxel towards smaller (below) or larger x (above).
Word from_above(const Word* row, int w, int words) {
  return row[w] >> 1 | (w + 1 < words ? row[w + 1] << 63 : 0);
}
Word from_below(const Word* row, int w) { return row[w] << 1 | (w > 0 ? row[w - 1] >> 63 : 0); }

/// Combines the 3 x 3 rows round a row into `out` (and, or), word by word.
template <class Combine>
void combine_nine(const BitView& bits, const Word* base, int y, int z, Word* out,
                  const Combine& combine) {
  const int words = bits.words_per_row;
  std::copy_n(base + bits.row(y, z), words, out);
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy) {
      const Word* row = base + bits.row(y + dy, z + dz);
      for (int w = 0; w < words; ++w) out[w] = combine(out[w], row[w]);
    }
}

/// out = the row eroded, or dilated, along x by one voxel.
void erode_x(const Word* row, int words, Word* out) {
  for (int w = 0; w < words; ++w) out[w] = row[w] & from_above(row, w, words) & from_below(row, w);
}
void dilate_x(const Word* row, int words, Word* out) {
  for (int w = 0; w < words; ++w) out[w] = row[w] | from_above(row, w, words) | from_below(row, w);
}

/// True where one of the 3 x 3 rows round row (y, z) is flagged.
bool any_near(const BitView& bits, const std::vector<std::uint8_t>& flags, int y, int z) {
  for (int dz = -1; dz <= 1; ++dz) {
    const std::uint8_t* f = flags.data() + static_cast<std::size_t>(z + dz) * bits.size[1] + y;
    if (f[-1] | f[0] | f[1]) return true;
  }
  return false;
}

/// Outer boundary voxels of one row: background with an object 6-neighbour, added to `out`.
void add_boundary(const BitView& object, int y, int z, Word* out) {
  const int words = object.words_per_row;
  const Word* base = object.words.data();
  const Word* own = base + object.row(y, z);
  const Word* none = nullptr;
  const Word* beside[4] = {y > 0 ? own - words : none, y + 1 < object.size[1] ? own + words : none,
                           z > 0 ? base + object.row(y, z - 1) : none,
                           z + 1 < object.size[2] ? base + object.row(y, z + 1) : none};
  for (int w = 0; w < words; ++w) {
    Word near = from_above(own, w, words) | from_below(own, w);
    for (const Word* row : beside)
      if (row) near |= row[w];
    out[w] |= near & ~own[w];
  }
}

/// True where no object lies in or beside the brick row (by, bz).
bool brick_row_is_empty(const BitView& object, int by, int bz) {
  const int y0 = std::max(8 * by - 1, 0), y1 = std::min(8 * by + 9, object.size[1]);
  const int z0 = std::max(8 * bz - 1, 0), z1 = std::min(8 * bz + 9, object.size[2]);
  for (int z = z0; z < z1; ++z)
    if (!is_empty(object.words.data() + object.row(y0, z), (y1 - y0) * object.words_per_row))
      return false;
  return true;
}

/// Sets the two bits of an octant row (dy, dz) in each brick of a brick row, from its 4 x 4 rows.
void mark_octant_row(const Word* boundary, int bricks, int octant_row, std::uint8_t* octants) {
  for (int b = 0; b < bricks; ++b) {
    const Word eight = boundary[b / 8] >> (8 * (b % 8)) & 0xffu;
    const unsigned pair = (eight & 0x0fu ? 1u : 0u) | (eight & 0xf0u ? 2u : 0u);
    octants[b] = static_cast<std::uint8_t>(octants[b] | pair << (2 * octant_row));
  }
}

}  // namespace

void TbbBackend::volume_pack(const VolumeView& volume, const std::array<int, 3>& size,
                             int words_per_row, View<std::uint64_t> words) {
  const std::size_t ny = size[1], rows = ny * size[2];
  const auto inside = [](std::int64_t i, std::int64_t n) { return i >= kPad && i < kPad + n; };
  for_each(rows, kRowGrain, [&](std::size_t row) {
    Word* out = words.data() + row * words_per_row;
    const auto y = static_cast<std::int64_t>(row % ny), z = static_cast<std::int64_t>(row / ny);
    const auto& given = volume.geometry.size;
    if (inside(y, given[1]) && inside(z, given[2]))
      pack_row(volume, static_cast<std::size_t>((z - kPad) * given[1] + (y - kPad)), out,
               words_per_row);
    else
      std::fill_n(out, words_per_row, Word{0});
  });
}

void TbbBackend::points_thin_mask(const BitView& object, View<std::uint64_t> thin,
                                  View<std::uint64_t> refine) {
  const int words = object.words_per_row, ny = object.size[1], nz = object.size[2];
  const std::size_t rows = static_cast<std::size_t>(ny) * nz;
  const Word* bits = object.words.data();
  std::vector<std::uint8_t> is_thin(rows, 0);
  const auto for_rows = [&](const auto& body) {
    for_each(nz, 1, [&](std::size_t z) {
      std::vector<Word> nine(words);
      for (int y = 0; y < ny; ++y) {
        const bool rim = y == 0 || y == ny - 1 || z == 0 || static_cast<int>(z) == nz - 1;
        body(y, static_cast<int>(z), rim, nine.data());
      }
    });
  };
  const auto any_of = [](Word a, Word b) { return a | b; };
  const auto all_of = [](Word a, Word b) { return a & b; };

  // refine = O eroded, for the time being
  for_rows([&](int y, int z, bool rim, Word* nine) {
    Word* out = refine.data() + object.row(y, z);
    if (rim || is_empty(bits + object.row(y, z), words)) {
      std::fill_n(out, words, Word{0});
      return;
    }
    combine_nine(object, bits, y, z, nine, all_of);
    erode_x(nine, words, out);
  });
  // thin = O and not (the eroded O dilated)
  for_rows([&](int y, int z, bool rim, Word* nine) {
    const Word* own = bits + object.row(y, z);
    Word* out = thin.data() + object.row(y, z);
    if (rim || is_empty(own, words)) {
      std::fill_n(out, words, Word{0});
      return;
    }
    combine_nine(object, refine.data(), y, z, nine, any_of);
    dilate_x(nine, words, out);
    for (int w = 0; w < words; ++w) out[w] = own[w] & ~out[w];
    is_thin[static_cast<std::size_t>(z) * ny + y] = !is_empty(out, words);
  });
  // refine = thin dilated
  for_rows([&](int y, int z, bool rim, Word* nine) {
    Word* out = refine.data() + object.row(y, z);
    if (rim || !any_near(object, is_thin, y, z)) {
      std::fill_n(out, words, Word{0});
      return;
    }
    combine_nine(object, thin.data(), y, z, nine, any_of);
    dilate_x(nine, words, out);
  });
}

void TbbBackend::points_mark_bricks(const BitView& object, View<std::uint8_t> octants) {
  const int nx = object.size[0] / kBrickSide, ny = object.size[1] / kBrickSide,
            nz = object.size[2] / kBrickSide;
  for_each(static_cast<std::size_t>(ny) * nz, 4, [&](std::size_t brick_row) {
    const int by = static_cast<int>(brick_row % ny), bz = static_cast<int>(brick_row / ny);
    std::uint8_t* out = octants.data() + brick_row * nx;
    std::fill_n(out, nx, std::uint8_t{0});
    if (brick_row_is_empty(object, by, bz)) return;
    std::vector<Word> boundary(object.words_per_row);
    for (int octant_row = 0; octant_row < 4; ++octant_row) {
      std::fill(boundary.begin(), boundary.end(), Word{0});
      const int y0 = 8 * by + 4 * (octant_row & 1), z0 = 8 * bz + 4 * (octant_row >> 1);
      for (int row = 0; row < 16; ++row)
        add_boundary(object, y0 + row % 4, z0 + row / 4, boundary.data());
      mark_octant_row(boundary.data(), nx, octant_row, out);
    }
  });
}

}  // namespace vasamesh

#include "stages/runs.h"

#include <bit>
#include <utility>

#include "backend/ranges.h"
#include "stages/disjoint_sets.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr int kSlab = 16;  // layers of z a task takes

/// Appends the runs of set bits of words ^ flip among the row's first `length` bits.
void append_row(const std::uint64_t* words, int length, std::uint64_t flip,
                std::vector<Run>& runs) {
  const int word_count = (length + 63) / 64;
  std::uint64_t before = 0;
  for (int i = 0; i < word_count; ++i) {
    std::uint64_t bits = words[i] ^ flip;
    if (i == word_count - 1 && length % 64) bits &= (std::uint64_t{1} << (length % 64)) - 1;
    std::uint64_t changes = bits ^ ((bits << 1) | before);
    before = bits >> 63;
    for (; changes; changes &= changes - 1) {
      const int x = 64 * i + std::countr_zero(changes);
      if ((bits >> (x & 63)) & 1)
        runs.push_back({x, x});
      else
        runs.back().end = x;
    }
  }
  if (before) runs.back().end = length;
}

struct Slab {
  std::vector<Run> runs;
  std::vector<std::uint32_t> row_sizes;
};

Slab collect_slab(const BitView& bits, const RowWindow& window, int z_first, int z_last,
                  std::uint64_t flip) {
  Slab slab;
  for (int z = z_first; z < z_last; ++z)
    for (int y = 0; y < bits.size[1]; ++y) {
      const std::size_t before = slab.runs.size();
      if (y >= window.first[0] && y < window.last[0] && z >= window.first[1] && z < window.last[1])
        append_row(bits.words.data() + bits.row(y, z), bits.size[0], flip, slab.runs);
      slab.row_sizes.push_back(static_cast<std::uint32_t>(slab.runs.size() - before));
    }
  return slab;
}

/// Unites the runs of two rows that touch; runs at most `reach` - 1 voxels apart count.
void unite_rows(const RunTable& table, std::size_t row, std::size_t other, int reach,
                DisjointSets& sets) {
  std::uint32_t a = table.row_first[row], b = table.row_first[other];
  const std::uint32_t a_end = table.row_first[row + 1], b_end = table.row_first[other + 1];
  while (a < a_end && b < b_end) {
    const Run& s = table.runs[a];
    const Run& t = table.runs[b];
    if (s.begin < t.end + reach && t.begin < s.end + reach) sets.unite(a, b);
    (s.end < t.end ? a : b)++;
  }
}

/// Unites the rows of layer z with rows before them: in the layer itself, or in the one below.
void unite_layer(const RunTable& table, int z, bool below, int connectivity, DisjointSets& sets) {
  const int rows = table.size[1];
  const int face_reach = connectivity == 6 ? 0 : 1;
  const int edge_reach = connectivity == 26 ? 1 : 0;
  for (int y = 0; y < rows; ++y) {
    if (table.row_empty(y, z)) continue;
    const std::size_t row = static_cast<std::size_t>(z) * rows + y;
    if (!below) {
      if (y > 0) unite_rows(table, row, row - 1, face_reach, sets);
      continue;
    }
    unite_rows(table, row, row - rows, face_reach, sets);
    if (connectivity == 6) continue;
    if (y > 0) unite_rows(table, row, row - rows - 1, edge_reach, sets);
    if (y + 1 < rows) unite_rows(table, row, row - rows + 1, edge_reach, sets);
  }
}

}  // namespace

RunTable collect_runs(Backend& backend, const BitView& bits, const RowWindow& window, bool set) {
  const std::uint64_t flip = set ? 0 : ~std::uint64_t{0};
  std::vector<Slab> parts =
      map_ranges(backend, bits.size[2], kSlab, [&](std::size_t begin, std::size_t end) {
        return collect_slab(bits, window, static_cast<int>(begin), static_cast<int>(end), flip);
      });
  RunTable table{bits.size, {0}, {}};
  std::size_t total = 0;
  for (const Slab& part : parts) total += part.runs.size();
  if (total > 0x7fffffffu)
    throw Error(ErrorCode::refused,
                "the segmentation has more than 2^31 runs of voxels: convert a part of it");
  table.runs.reserve(total);
  table.row_first.reserve(static_cast<std::size_t>(bits.size[1]) * bits.size[2] + 1);
  for (Slab& part : parts) {
    table.runs.insert(table.runs.end(), part.runs.begin(), part.runs.end());
    for (std::uint32_t size : part.row_sizes)
      table.row_first.push_back(table.row_first.back() + size);
    part = {};
  }
  return table;
}

std::vector<std::uint32_t> connect_runs(Backend& backend, const RunTable& table, int connectivity) {
  DisjointSets sets(table.runs.size());
  const int layers = table.size[2];
  for_each_range(backend, layers, kSlab, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z) {
      unite_layer(table, static_cast<int>(z), false, connectivity, sets);
      if (z > begin) unite_layer(table, static_cast<int>(z), true, connectivity, sets);
    }
  });
  for (int z = kSlab; z < layers; z += kSlab) unite_layer(table, z, true, connectivity, sets);
  return std::move(sets).roots();
}

}  // namespace vasamesh

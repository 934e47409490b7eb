#include "stages/euler.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <memory>
#include <utility>

#include "backend/ranges.h"

namespace vasamesh {

namespace {

constexpr int kSlab = 16;  // layers of corners a task takes

/// One connected part of the object among the eight voxels round a corner. Voxel dx + 2 dy + 4 dz.
struct Part {
  std::int8_t voxel;  ///< one of its voxels
  std::int8_t share;  ///< eight times its share of the Euler characteristic
};

/// What a configuration of eight voxels contributes.
struct Configuration {
  std::int8_t part_count = 0;
  std::array<Part, 4> parts{};
  std::int8_t edge_contacts = 0;  ///< over the edges from the corner towards +x, +y, +z
  std::int8_t edge_voxel = 0;     ///< an object voxel of the first of them
  bool corner_contact = false;
};

bool touching(int a, int b, int connectivity) {
  const int differing = std::popcount(static_cast<unsigned>(a ^ b));
  return differing <= (connectivity == 6 ? 1 : connectivity == 18 ? 2 : 3);
}

/// Cells of `dimension` at the corner whose voxels are inside: any of them, or all of them. A cell
/// is named by the axes that it extends along and the side of the corner that it lies on.
int cells_inside(unsigned voxels, int dimension, bool all) {
  int count = 0;
  for (unsigned axes = 0; axes < 8; ++axes) {
    if (std::popcount(axes) != dimension) continue;
    for (unsigned side = 0; side < 8; ++side) {
      if (side & ~axes) continue;
      unsigned touching_cell = 0;
      for (unsigned v = 0; v < 8; ++v)
        if ((v & axes) == side) touching_cell |= 1u << v;
      const unsigned inside = voxels & touching_cell;
      count += all ? inside == touching_cell : inside != 0;
    }
  }
  return count;
}

int share_of(unsigned voxels, int connectivity) {
  const bool all = connectivity == 6;
  const int share = 8 * cells_inside(voxels, 0, all) - 4 * cells_inside(voxels, 1, all) +
                    2 * cells_inside(voxels, 2, all) - cells_inside(voxels, 3, all);
  return all ? -share : share;  // an open solid: chi = -chi_c in three dimensions
}

unsigned part_from(unsigned voxels, int seed, int connectivity) {
  unsigned part = 1u << seed;
  for (unsigned before = 0; before != part;) {
    before = part;
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        if ((part >> a & 1) && (voxels >> b & 1) && touching(a, b, connectivity)) part |= 1u << b;
  }
  return part;
}

void count_edge_contacts(unsigned voxels, Configuration& result) {
  constexpr int kPairs[6][4] = {{1, 7, 3, 5}, {3, 5, 1, 7}, {2, 7, 3, 6},
                                {3, 6, 2, 7}, {4, 7, 5, 6}, {5, 6, 4, 7}};
  for (const auto& pair : kPairs) {
    const bool object = (voxels >> pair[0] & 1) && (voxels >> pair[1] & 1);
    const bool background = !(voxels >> pair[2] & 1) && !(voxels >> pair[3] & 1);
    if (!object || !background) continue;
    if (result.edge_contacts++ == 0) result.edge_voxel = static_cast<std::int8_t>(pair[0]);
  }
}

std::array<Configuration, 256> make_table(int connectivity) {
  std::array<Configuration, 256> table;
  for (unsigned voxels = 1; voxels < 255; ++voxels) {
    Configuration& c = table[voxels];
    for (unsigned left = voxels; left;) {
      const int seed = std::countr_zero(left);
      const unsigned part = part_from(voxels, seed, connectivity);
      c.parts[c.part_count++] = {static_cast<std::int8_t>(seed),
                                 static_cast<std::int8_t>(share_of(part, connectivity))};
      left &= ~part;
    }
    count_edge_contacts(voxels, c);
    const int lowest = std::countr_zero(voxels);
    c.corner_contact = voxels == ((1u << lowest) | (1u << (7 - lowest)));
  }
  return table;
}

/// The piece of object voxels along one row. May be asked for x, then x - 1 (both in one run, where
/// both are object), but not for less.
class RowCursor {
 public:
  RowCursor(const RunTable& runs, const std::vector<std::int32_t>& piece, int y, int z)
      : run_(runs.runs.data()), piece_(piece.data()) {
    at_ = runs.row_first[static_cast<std::size_t>(z) * runs.size[1] + y];
  }
  std::int32_t piece(int x) {
    while (run_[at_].end <= x) ++at_;
    return piece_[at_];
  }

 private:
  const Run* run_;
  const std::int32_t* piece_;
  std::uint32_t at_;
};

/// What one task counts. Sums of integers, so that the order does not matter.
class Counter {
 public:
  Counter(const BitView& object, const RunTable& runs, const std::vector<std::int32_t>& piece,
          const std::array<Configuration, 256>& table, std::atomic<std::int64_t>* euler)
      : object_(object), runs_(runs), piece_(piece), table_(table), euler_(euler) {}
  ~Counter() { flush(); }
  Counter(const Counter&) = delete;
  Counter& operator=(const Counter&) = delete;

  /// The corners between the rows y - 1, y and the layers z - 1, z.
  void count_row(int y, int z) {
    if (runs_.row_empty(y - 1, z - 1) && runs_.row_empty(y, z - 1) && runs_.row_empty(y - 1, z) &&
        runs_.row_empty(y, z))
      return;
    RowCursor cursor[4] = {{runs_, piece_, y - 1, z - 1},
                           {runs_, piece_, y, z - 1},
                           {runs_, piece_, y - 1, z},
                           {runs_, piece_, y, z}};
    const std::uint64_t* words = object_.words.data();
    const std::uint64_t* row[4] = {words + object_.row(y - 1, z - 1), words + object_.row(y, z - 1),
                                   words + object_.row(y - 1, z), words + object_.row(y, z)};
    std::uint64_t carry[4] = {};
    for (int i = 0; i < object_.words_per_row; ++i) {
      std::uint64_t bits[8], any = 0, all = ~std::uint64_t{0};
      for (int r = 0; r < 4; ++r) {
        bits[2 * r + 1] = row[r][i];
        bits[2 * r] = (row[r][i] << 1) | carry[r];
        carry[r] = row[r][i] >> 63;
        any |= bits[2 * r] | bits[2 * r + 1];
        all &= bits[2 * r] & bits[2 * r + 1];
      }
      for (std::uint64_t mixed = any & ~all; mixed; mixed &= mixed - 1) {
        const int shift = std::countr_zero(mixed);
        unsigned voxels = 0;
        for (int b = 0; b < 8; ++b) voxels |= static_cast<unsigned>(bits[b] >> shift & 1) << b;
        count_corner(table_[voxels], 64 * i + shift, y, z, voxels, cursor);
      }
    }
  }

  Finding edge_contacts, corner_contacts;

 private:
  void count_corner(const Configuration& c, int x, int y, int z, unsigned voxels,
                    RowCursor* cursor) {
    for (int i = 0; i < c.part_count; ++i) {
      const Part part = c.parts[i];
      add(cursor[part.voxel >> 1].piece(x - 1 + (part.voxel & 1)), part.share);
    }
    if (c.edge_contacts) note(edge_contacts, c.edge_contacts, x, y, z, c.edge_voxel);
    if (c.corner_contact) note(corner_contacts, 1, x, y, z, std::countr_zero(voxels));
  }

  static void note(Finding& finding, int count, int x, int y, int z, int voxel) {
    if (finding.count == 0)
      finding.place = {x - 1 + (voxel & 1), y - 1 + (voxel >> 1 & 1), z - 1 + (voxel >> 2)};
    finding.count += count;
  }

  void add(std::int32_t piece, int share) {
    if (piece != current_) flush();
    current_ = piece;
    sum_ += share;
  }
  void flush() {
    if (sum_) euler_[current_].fetch_add(sum_, std::memory_order_relaxed);
    sum_ = 0;
  }

  const BitView& object_;
  const RunTable& runs_;
  const std::vector<std::int32_t>& piece_;
  const std::array<Configuration, 256>& table_;
  std::atomic<std::int64_t>* euler_;
  std::int32_t current_ = 0;
  std::int64_t sum_ = 0;
};

void append(Finding& to, const Finding& part) {
  if (to.count == 0) to.place = part.place;
  to.count += part.count;
}

}  // namespace

CornerCounts count_corners(Backend& backend, const BitView& object, const RunTable& runs,
                           const std::vector<std::int32_t>& piece, std::size_t piece_count,
                           int connectivity) {
  const auto table = make_table(connectivity);
  const auto euler = std::make_unique<std::atomic<std::int64_t>[]>(piece_count);

  const auto count = [&](std::size_t begin, std::size_t end) {
    Counter counter(object, runs, piece, table, euler.get());
    for (std::size_t z = std::max<std::size_t>(begin, 1); z < end; ++z)
      for (int y = 1; y < object.size[1]; ++y) counter.count_row(y, static_cast<int>(z));
    return std::pair{counter.edge_contacts, counter.corner_contacts};
  };
  CornerCounts result;
  for (const auto& [edges, corners] : map_ranges(backend, object.size[2], kSlab, count)) {
    append(result.edge_contacts, edges);
    append(result.corner_contacts, corners);
  }
  for (std::size_t p = 0; p < piece_count; ++p) result.euler.push_back(euler[p] / 8);
  return result;
}

}  // namespace vasamesh

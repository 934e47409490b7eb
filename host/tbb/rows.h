#pragma once

/// \file
/// Rows of eight cells as vectors, for passes over bricks. Their arithmetic is that of each lane;
/// the compiler gives them the widest registers that it may use.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "types/bricks.h"

namespace vasamesh {

using Row = float __attribute__((vector_size(32)));             ///< eight values
using RowMask = std::int32_t __attribute__((vector_size(32)));  ///< all bits set, or none

inline Row load_row(const float* from) {
  Row row;
  std::memcpy(&row, from, sizeof row);
  return row;
}

inline void store_row(float* to, const Row& row) { std::memcpy(to, &row, sizeof row); }

/// Where the eight bytes are not zero. Each lane looks at its byte of the word that holds it: the
/// widening of bytes takes compilers ten times as many instructions.
inline RowMask load_mask(const std::uint8_t* from) {
  constexpr RowMask kByte = {0xff, 0xff00, 0xff0000, ~0xffffff, 0xff, 0xff00, 0xff0000, ~0xffffff};
  std::int32_t word[2];
  std::memcpy(word, from, sizeof word);
  const RowMask low = word[0] - RowMask{}, high = word[1] - RowMask{};
  return (__builtin_shufflevector(low, high, 0, 1, 2, 3, 12, 13, 14, 15) & kByte) != 0;
}

/// `row` where the mask is set, else 0.
inline Row where(const RowMask& mask, const Row& row) {
  return reinterpret_cast<Row>(reinterpret_cast<RowMask>(row) & mask);
}

/// What passes ask of eight lanes at once.
struct RowLanes {
  using Number = Row;
  static bool any(const RowMask& mask) {
    std::uint64_t parts[4];
    std::memcpy(parts, &mask, sizeof parts);
    return ((parts[0] | parts[1]) | (parts[2] | parts[3])) != 0;
  }
  static Row absolute(const Row& row) { return row < 0.0f ? -row : row; }
  static Row square_root(const Row& row) {
    float values[8];
    std::memcpy(values, &row, sizeof values);
    for (float& value : values) value = std::sqrt(value);
    return load_row(values);
  }
};

/// The row one cell further: the last seven values, then `next`.
inline Row shifted_down(const Row& row, float next) {
  return __builtin_shufflevector(row, Row{next}, 1, 2, 3, 4, 5, 6, 7, 8);
}

/// The row one cell before: `previous`, then the first seven values.
inline Row shifted_up(const Row& row, float previous) {
  return __builtin_shufflevector(Row{previous}, row, 0, 8, 9, 10, 11, 12, 13, 14);
}

/// Sum of the eight values in the order that the contract states.
inline float sum_of_row(const Row& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/// The bricks of a field in a table of `side` along each axis; zeros where there is none. Cells are
/// counted from the table's corner.
class BrickTable {
 public:
  BrickTable(const std::int32_t* bricks, int side, const float* field)
      : bricks_(bricks), side_(side), field_(field) {}

  /// Row (y, z) of the brick `x` along its axis.
  Row row(int x, int y, int z) const {
    const float* brick = find(x, y >> 3, z >> 3);
    return brick ? load_row(brick + brick_cell(0, y & 7, z & 7)) : Row{};
  }
  float cell(int x, int y, int z) const {
    const float* brick = find(x >> 3, y >> 3, z >> 3);
    return brick ? brick[brick_cell(x & 7, y & 7, z & 7)] : 0.0f;
  }

 private:
  const float* find(int x, int y, int z) const {
    const std::int32_t brick = bricks_[x + side_ * (y + side_ * z)];
    return brick == kNoBrick ? nullptr : field_ + std::size_t{kBrickCells} * brick;
  }

  const std::int32_t* bricks_;
  int side_;
  const float* field_;
};

/// A brick of a field and its face neighbours, by rows of eight; zeros where there is none.
struct BrickRows {
  BrickRows(const BrickView& bricks, std::size_t brick, const float* field) {
    static constexpr float kZeros[kBrickCells] = {};
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    const auto from = [&](int dx, int dy, int dz) {
      const std::int32_t b = near[brick_neighbour(dx, dy, dz)];
      return b == kNoBrick ? kZeros : field + std::size_t{kBrickCells} * b;
    };
    own = from(0, 0, 0);
    left = from(-1, 0, 0), right = from(1, 0, 0);
    front = from(0, -1, 0), back = from(0, 1, 0);
    below = from(0, 0, -1), above = from(0, 0, 1);
  }

  /// Row (y, z); one of the two may be -1 or 8.
  Row row(int y, int z) const {
    const float* brick = y < 0 ? front : y > 7 ? back : z < 0 ? below : z > 7 ? above : own;
    return load_row(brick + brick_cell(0, y & 7, z & 7));
  }

  const float *own, *left, *right, *front, *back, *below, *above;
};

}  // namespace vasamesh

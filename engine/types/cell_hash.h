#pragma once

/// \file
/// The cells of a grid without bounds, hashed to the slots of a table.
///
/// Teschner, Heidelberger, Mueller, Pomerantes, Gross: Optimized spatial hashing for collision
/// detection of deformable objects, 2003.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "types/box.h"

namespace vasamesh {

/// No coordinate is negative; what is below zero counts as zero.
class CellHash {
 public:
  CellHash() = default;

  /// Slots for so many entries. \param inverse_side  of a cell.
  CellHash(float inverse_side, std::size_t entries)
      : inverse_side_(inverse_side),
        mask_(static_cast<std::uint32_t>(std::bit_ceil(entries + 1) - 1)) {}

  std::size_t slots() const { return std::size_t{mask_} + 1; }
  float inverse_side() const { return inverse_side_; }

  std::uint32_t slot_of(const Vec3& p) const {
    return slot_of(cell_of(p.x), cell_of(p.y), cell_of(p.z));
  }

  /// visit(slot) for the cells that a box reaches into; a slot may come more than once.
  template <class Visit>
  void for_each_slot(const Box& box, const Visit& visit) const {
    for (std::uint32_t z = cell_of(box.low.z); z <= cell_of(box.high.z); ++z)
      for (std::uint32_t y = cell_of(box.low.y); y <= cell_of(box.high.y); ++y)
        for (std::uint32_t x = cell_of(box.low.x); x <= cell_of(box.high.x); ++x)
          visit(slot_of(x, y, z));
  }

 private:
  std::uint32_t cell_of(float x) const {
    return static_cast<std::uint32_t>(inverse_side_ * std::max(x, 0.0f));
  }
  std::uint32_t slot_of(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (x * 73856093u ^ y * 19349663u ^ z * 83492791u) & mask_;
  }

  float inverse_side_ = 1;
  std::uint32_t mask_ = 0;
};

}  // namespace vasamesh

#pragma once

/// \file
/// Runs of voxels along x, and their connected components.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "types/volume.h"

namespace vasamesh {

/// Voxels begin .. end - 1 of one row.
struct Run {
  std::int32_t begin, end;
};

/// Runs in raster order. Row y + size[1] z has the runs row_first[row] .. row_first[row + 1] - 1.
struct RunTable {
  std::array<int, 3> size{0, 0, 0};
  std::vector<std::uint32_t> row_first;
  std::vector<Run> runs;

  std::span<const Run> row(int y, int z) const {
    const std::size_t at = static_cast<std::size_t>(z) * size[1] + y;
    return std::span(runs).subspan(row_first[at], row_first[at + 1] - row_first[at]);
  }
  bool row_empty(int y, int z) const { return row(y, z).empty(); }
};

/// A window of rows: y from first[0] below last[0], z from first[1] below last[1].
struct RowWindow {
  std::array<int, 2> first, last;
};

/// The runs of set bits, or of clear ones, of the rows in the window. \throws Error refused beyond
/// 2^31 runs.
RunTable collect_runs(Backend& backend, const BitView& bits, const RowWindow& window, bool set);

/// The lowest run of the component of each run, under 6-, 18- or 26-connectivity of voxels.
std::vector<std::uint32_t> connect_runs(Backend& backend, const RunTable& table, int connectivity);

}  // namespace vasamesh

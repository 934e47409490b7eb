#include "stages/constant_blocks.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

namespace vasamesh {

namespace {

constexpr int kLeastChanges = 8;  // along an axis

/// A byte a plane between voxels: whether labels change there anywhere.
using Changes = std::vector<std::uint8_t>;

bool are_equal(std::span<const Run> a, std::span<const Run> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Run& r, const Run& s) {
    return r.begin == s.begin && r.end == s.end;
  });
}

std::int64_t block_of(const Changes& changes) {
  std::int64_t block = 0, first = -1, count = 0;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (!changes[i]) continue;
    if (first < 0) first = static_cast<std::int64_t>(i);
    block = std::gcd(block, static_cast<std::int64_t>(i) - first);
    ++count;
  }
  return count < kLeastChanges ? 1 : block;
}

}  // namespace

std::array<std::int64_t, 3> constant_blocks(const RunTable& table) {
  std::array<Changes, 3> changes;
  for (std::size_t a = 0; a < 3; ++a)
    changes[a].assign(static_cast<std::size_t>(table.size[a]) + 1, 0);
  for (const Run& run : table.runs)
    changes[0][static_cast<std::size_t>(run.begin)] =
        changes[0][static_cast<std::size_t>(run.end)] = 1;
  for (int z = 0; z < table.size[2]; ++z)
    for (int y = 0; y < table.size[1]; ++y) {
      const std::span<const Run> here = table.row(y, z);
      if (y > 0 && !are_equal(here, table.row(y - 1, z)))
        changes[1][static_cast<std::size_t>(y)] = 1;
      if (z > 0 && !are_equal(here, table.row(y, z - 1)))
        changes[2][static_cast<std::size_t>(z)] = 1;
    }
  return {block_of(changes[0]), block_of(changes[1]), block_of(changes[2])};
}

}  // namespace vasamesh

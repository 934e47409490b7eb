#include "stages/bricks.h"

#include <algorithm>

#include "backend/ranges.h"

namespace vasamesh {

namespace {

/// Of the row that a brick lies in: less where the row comes before.
std::int64_t row_key(const BrickCoord& c) {
  return std::int64_t{c.z} * (std::int64_t{1} << 32) + std::int64_t{c.y};
}

/// The index of the first coordinate of each row (y, z) that bricks lie in, with an end marker.
struct RowTable {
  explicit RowTable(std::span<const BrickCoord> bricks) : coords(bricks) {
    if (coords.empty()) return;
    const auto by_y = [](const BrickCoord& a, const BrickCoord& b) { return a.y < b.y; };
    const auto [low, high] = std::minmax_element(coords.begin(), coords.end(), by_y);
    y_min = low->y;
    z_min = coords.front().z;
    y_count = high->y - y_min + 1;
    z_count = coords.back().z - z_min + 1;
    start.assign(static_cast<std::size_t>(y_count) * z_count + 1, 0);
    for (const BrickCoord& c : coords) ++start[row(c.y, c.z) + 1];
    for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  }

  std::size_t row(int y, int z) const {
    return static_cast<std::size_t>(z - z_min) * y_count + (y - y_min);
  }

  /// Writes the indices of the `count` bricks from x on in a row.
  void find_run(int x, int y, int z, int count, std::int32_t* out) const {
    std::fill_n(out, count, kNoBrick);
    if (y < y_min || y >= y_min + y_count || z < z_min || z >= z_min + z_count) return;
    const auto end = coords.begin() + static_cast<std::ptrdiff_t>(start[row(y, z) + 1]);
    auto it = std::lower_bound(coords.begin() + static_cast<std::ptrdiff_t>(start[row(y, z)]), end,
                               x, [](const BrickCoord& c, int value) { return c.x < value; });
    for (; it != end && it->x < x + count; ++it)
      out[it->x - x] = static_cast<std::int32_t>(it - coords.begin());
  }

  std::span<const BrickCoord> coords;
  std::vector<std::size_t> start;
  int y_min = 0, z_min = 0, y_count = 0, z_count = 0;
};

/// The indices of the coordinates of each layer (z).
struct LayerTable {
  explicit LayerTable(std::span<const BrickCoord> coords) : order(coords.size()) {
    const auto by_z = [](const BrickCoord& a, const BrickCoord& b) { return a.z < b.z; };
    const auto [low, high] = std::minmax_element(coords.begin(), coords.end(), by_z);
    if (!coords.empty()) z_min = low->z;
    start.assign(coords.empty() ? 2 : static_cast<std::size_t>(high->z - z_min) + 3, 0);
    // Starts go two entries on; entry layer + 1 then runs from the layer's start to its end.
    for (const BrickCoord& c : coords) ++start[static_cast<std::size_t>(c.z - z_min) + 2];
    for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
    for (std::uint32_t i = 0; i < coords.size(); ++i)
      order[start[static_cast<std::size_t>(coords[i].z - z_min) + 1]++] = i;
  }

  std::size_t count() const { return start.size() - 2; }
  std::span<const std::uint32_t> at(int z) const {
    const auto layer = static_cast<std::size_t>(z - z_min);
    if (z < z_min || layer >= count()) return {};
    return std::span(order).subspan(start[layer], start[layer + 1] - start[layer]);
  }

  std::vector<std::uint32_t> order;
  std::vector<std::size_t> start;
  int z_min = 0;
};

/// A brick and those on the sides of its set octants: bit brick_neighbour(dx, dy, dz).
std::uint32_t reached_by(std::uint8_t octants) {
  std::uint32_t reached = 0;
  for (int octant = 0; octant < 8; ++octant) {
    if (!(octants >> octant & 1)) continue;
    for (int side = 0; side < 8; ++side) {
      const auto step = [&](int axis) {
        return side >> axis & 1 ? (octant >> axis & 1 ? 1 : -1) : 0;
      };
      reached |= 1u << brick_neighbour(step(0), step(1), step(2));
    }
  }
  return reached;
}

/// Appends those that a brick reaches in the layer `dz` from its own.
void add_reached(const BrickCoord& brick, std::uint32_t reached, int dz,
                 std::vector<BrickCoord>& found) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (reached >> brick_neighbour(dx, dy, dz) & 1)
        found.push_back({brick.x + dx, brick.y + dy, brick.z + dz});
}

}  // namespace

bool raster_before(const BrickCoord& a, const BrickCoord& b) {
  const std::int64_t a_row = row_key(a), b_row = row_key(b);
  return a_row != b_row ? a_row < b_row : a.x < b.x;
}

void sort_unique(std::vector<BrickCoord>& coords) {
  std::sort(coords.begin(), coords.end(), raster_before);
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
}

Buffer<std::int32_t> brick_windows(Backend& backend, std::span<const BrickCoord> corners, int side,
                                   std::span<const BrickCoord> bricks) {
  const RowTable rows(bricks);
  const auto volume = static_cast<std::size_t>(side * side * side);
  std::vector<std::int32_t> table(volume * corners.size());
  constexpr std::size_t kGrain = 256;
  for_each_index(backend, corners.size(), kGrain, [&](std::size_t i) {
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        rows.find_run(corners[i].x, corners[i].y + y, corners[i].z + z, side,
                      &table[volume * i + static_cast<std::size_t>(side * (y + side * z))]);
  });
  Buffer<std::int32_t> windows(backend, table.size());
  backend.upload<std::int32_t>(windows.view(), table);
  return windows;
}

Buffer<std::int32_t> neighbours_in(Backend& backend, std::span<const BrickCoord> coords,
                                   std::span<const BrickCoord> bricks) {
  std::vector<BrickCoord> corners(coords.begin(), coords.end());
  for (BrickCoord& c : corners) c = {c.x - 1, c.y - 1, c.z - 1};
  return brick_windows(backend, corners, 3, bricks);
}

Bricks make_bricks(Backend& backend, std::span<const BrickCoord> coords) {
  Bricks bricks;
  bricks.count = coords.size();
  bricks.coords = Buffer<BrickCoord>(backend, coords.size());
  bricks.neighbours = neighbours_in(backend, coords, coords);
  backend.upload(bricks.coords.view(), coords);
  return bricks;
}

std::vector<BrickCoord> dilate_by_octants(Backend& backend, std::span<const BrickCoord> coords,
                                          std::span<const std::uint8_t> octants) {
  const LayerTable layers(coords);
  std::vector<std::uint32_t> reached(coords.size());
  std::transform(octants.begin(), octants.end(), reached.begin(), reached_by);
  const auto dilate = [&](std::size_t layer, std::size_t /*end*/, std::vector<BrickCoord>& found) {
    const int z = layers.z_min + static_cast<int>(layer) - 1;
    for (const int dz : {-1, 0, 1})
      for (const std::uint32_t i : layers.at(z - dz)) add_reached(coords[i], reached[i], dz, found);
    sort_unique(found);
  };
  return collect<BrickCoord>(backend, layers.count() + 2, 1, dilate);  // one more on either side
}

}  // namespace vasamesh

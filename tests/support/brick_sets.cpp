#include "support/brick_sets.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace vasamesh {

std::vector<BrickCoord> random_bricks(int count, std::uint32_t seed) {
  int side = 1;
  while (side * side * side < 2 * count) ++side;
  std::vector<BrickCoord> all;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) all.push_back({x - side / 2, y - 1, z - side});
  std::vector<BrickCoord> chosen;
  std::sample(all.begin(), all.end(), std::back_inserter(chosen), count, std::mt19937(seed));
  return chosen;
}

std::vector<BrickCoord> shell_bricks(int radius) {
  std::vector<BrickCoord> bricks;
  for (int z = -radius - 1; z <= radius + 1; ++z)
    for (int y = -radius - 1; y <= radius + 1; ++y)
      for (int x = -radius - 1; x <= radius + 1; ++x)
        if (std::abs(std::sqrt(static_cast<double>(x * x + y * y + z * z)) - radius) <= 1)
          bricks.push_back({x, y, z});
  return bricks;
}

std::vector<float> random_floats(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random()) * 0x1p-31f - 1.0f;
  return values;
}

std::vector<float> awkward_floats(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed + 1000);
  std::vector<float> values = random_floats(count, seed);
  for (float& value : values) switch (random() % 16) {
      case 0:
        value = 0.0f;
        break;
      case 1:
        value = -0.0f;
        break;
      case 2:
        value *= 1e-6f;
        break;
      case 3:
        value *= 1e6f;
        break;
      case 4:
        value *= 0x1p-130f;
        break;
      default:
        break;
    }
  return values;
}

std::vector<std::uint8_t> random_mask(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> mask(count);
  for (std::uint8_t& bit : mask) bit = random() % 4 != 0;
  return mask;
}

}  // namespace vasamesh

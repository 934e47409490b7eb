#include "byte_plan.h"

#include <algorithm>

namespace vasamesh {

namespace {

constexpr std::size_t kLeastOfAPoint = 10 * sizeof(float), kMostOfAPoint = 2000;
constexpr std::size_t kLeastOfABrick = kBrickCells * sizeof(std::uint32_t);
constexpr std::size_t kMostOfAnOctreeBrick = 24 * kBrickCells, kMostOfItsPoint = 100;
constexpr std::size_t kMostOfAWord = 6 * sizeof(std::uint64_t);

}  // namespace

BytePlan plan_bytes(const BitView& object, const PointCloud& points, std::size_t octree_bricks) {
  const std::size_t words = object.word_count();
  return {sizeof(std::uint64_t) * words + kLeastOfAPoint * points.count +
              kLeastOfABrick * points.bricks.count,
          kMostOfAWord * words +
              std::max(kMostOfAPoint * points.count,
                       kMostOfItsPoint * points.count + kMostOfAnOctreeBrick * octree_bricks)};
}

}  // namespace vasamesh

#include "byte_plan.h"

namespace vasamesh {

namespace {

constexpr std::size_t kLeastOfAPoint = 350, kMostOfAPoint = 2000;
constexpr std::size_t kMostOfAWord = 6 * sizeof(std::uint64_t);

}  // namespace

BytePlan plan_bytes(const BitView& object, std::size_t points) {
  const std::size_t words = object.word_count();
  return {sizeof(std::uint64_t) * words + kLeastOfAPoint * points,
          kMostOfAWord * words + kMostOfAPoint * points};
}

}  // namespace vasamesh

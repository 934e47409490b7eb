#include "reference/poisson_reference.h"

#include <cmath>
#include <map>

namespace vasamesh::reference {

namespace {

using Cell = std::array<int, 3>;

Cell cell_of(const BrickCoord& brick, int index) {
  return {8 * brick.x + index % 8, 8 * brick.y + index / 8 % 8, 8 * brick.z + index / 64};
}

/// Values by cell; a cell that is not there is zero.
class Field {
 public:
  Field(const Level& level, const std::vector<float>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      values_[cell_of(level.bricks[i / 512], static_cast<int>(i % 512))] = values[i];
  }
  float at(Cell cell, int axis, int step) const {
    cell[axis] += step;
    const auto found = values_.find(cell);
    return found == values_.end() ? 0.0f : found->second;
  }

 private:
  std::map<Cell, float> values_;
};

}  // namespace

std::vector<float> poisson_apply(const Level& level, const std::vector<std::uint8_t>& unknown,
                                 const std::vector<float>& p) {
  const Field field(level, p);
  std::vector<float> q(p.size(), 0.0f);
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!unknown[i]) continue;
    const Cell cell = cell_of(level.bricks[i / 512], static_cast<int>(i % 512));
    float t[3];
    for (int axis = 0; axis < 3; ++axis)
      t[axis] = (2.0f * p[i] - field.at(cell, axis, -1)) - field.at(cell, axis, 1);
    q[i] = (level.weights[0] * t[0] + level.weights[1] * t[1]) + level.weights[2] * t[2];
  }
  return q;
}

std::vector<float> brick_sums(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<float> sums;
  for (std::size_t first = 0; first < a.size(); first += 512) {
    float lane[8];
    for (std::size_t x = 0; x < 8; ++x) {
      lane[x] = 0;
      for (std::size_t i = first + x; i < first + 512; i += 8) lane[x] = lane[x] + a[i] * b[i];
    }
    const float even = (lane[0] + lane[4]) + (lane[2] + lane[6]);
    const float odd = (lane[1] + lane[5]) + (lane[3] + lane[7]);
    sums.push_back(even + odd);
  }
  return sums;
}

std::vector<ExactSum> exact_brick_sums(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<ExactSum> sums(a.size() / 512);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double product = static_cast<double>(a[i]) * b[i];
    sums[i / 512].sum += product;
    sums[i / 512].magnitude += std::abs(product);
  }
  return sums;
}

}  // namespace vasamesh::reference

#include "reference/octree_reference.h"

#include <algorithm>
#include <cmath>

namespace vasamesh::reference {

namespace {

std::int64_t key(int x, int y, int z) {
  constexpr std::int64_t kHalf = 1 << 19;
  return x + kHalf + ((y + kHalf) + (z + kHalf) * 2 * kHalf) * 2 * kHalf;
}

}  // namespace

double bspline(double t) {
  const double a = std::abs(t);
  if (a >= 1.5) return 0;
  return a < 0.5 ? 0.75 - a * a : 0.5 * (1.5 - a) * (1.5 - a);
}

SplineField::SplineField(int exponent, std::span<const BrickCoord> bricks,
                         std::span<const float> values)
    : side_(std::ldexp(1.0, exponent)) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const BrickCoord& brick = bricks[i / kBrickCells];
    const int c = static_cast<int>(i % kBrickCells);
    cells_[key(8 * brick.x + c % 8, 8 * brick.y + c / 8 % 8, 8 * brick.z + c / 64)] = values[i];
  }
}

template <class Visit>
void SplineField::visit(const Position& position, const Visit& visit) const {
  std::array<int, 3> own;
  for (std::size_t axis = 0; axis < 3; ++axis)
    own[axis] = static_cast<int>(std::floor(position[axis] / side_));
  for (int z = own[2] - 1; z <= own[2] + 1; ++z)
    for (int y = own[1] - 1; y <= own[1] + 1; ++y)
      for (int x = own[0] - 1; x <= own[0] + 1; ++x)
        visit(cells_.find(key(x, y, z)), bspline(position[0] / side_ - x - 0.5) *
                                             bspline(position[1] / side_ - y - 0.5) *
                                             bspline(position[2] / side_ - z - 0.5));
}

double SplineField::at(const Position& position) const {
  double sum = 0;
  visit(position, [&](const auto& found, double weight) {
    if (found != cells_.end()) sum += weight * found->second;
  });
  return sum;
}

bool SplineField::covers(const Position& position) const {
  bool all = true;
  visit(position, [&](const auto& found, double) { all = all && found != cells_.end(); });
  return all;
}

double splatted(const PointView& points, const Scale& scale, const Kernel& kernel, int exponent,
                const std::array<int, 3>& cell) {
  const double cell_side = std::ldexp(1.0, exponent);
  double sum = 0;
  for (std::size_t p = 0; p < points.count; ++p) {
    const double blend = std::clamp(2.0 * points.thickness[p] - 0.5, 0.0, 1.0);
    const double knots = kernel.thin + (kernel.thick - kernel.thin) * blend;
    double at_cell[3], difference[3], volume = 1;  // of K along each axis; lengths in voxel lengths
    for (std::size_t i = 0; i < 3; ++i) {
      const double side = scale[i] * cell_side, width = std::max(knots, side);
      const double low = (cell[i] * cell_side - points.position[i][p]) * scale[i];
      at_cell[i] = bspline((low + side / 2) / width) / width;
      difference[i] = (bspline((low + side) / width) - bspline(low / width)) / width / side;
      volume *= side;
    }
    double weight = 0;
    for (std::size_t i = 0; i < 3; ++i) weight += double{points.area[i][p]} * points.normal[i][p];
    for (std::size_t i = 0; i < 3; ++i)
      sum += volume * weight * points.normal[i][p] * difference[i] * at_cell[(i + 1) % 3] *
             at_cell[(i + 2) % 3];
  }
  return sum;
}

}  // namespace vasamesh::reference

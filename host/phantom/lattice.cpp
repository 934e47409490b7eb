#include "phantom/lattice.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "tbb/task_order.h"

namespace vasamesh::phantom {
namespace {

constexpr int kVoxelBlock = 8;

bool single_block(const Block& block, int side) {
  for (int a = 0; a < 3; ++a)
    if (block.high[a] - block.low[a] > side) return false;
  return true;
}

/// The two halves of [low, high) along axis a, or the whole where it is short. Cut at a multiple of
/// `side`, so that leaves are full blocks.
std::vector<std::array<int, 2>> halves(const Block& block, int a, int side) {
  const int low = block.low[a], high = block.high[a];
  if (high - low <= side) return {{low, high}};
  const int middle = low + side * ((high - low + 2 * side - 1) / (2 * side));
  return {{low, middle}, {middle, high}};
}

void split(const Block& block, const VoxelGrid& lattice, int side, double margin,
           std::vector<Block>& found);

void split_children(const Block& block, const VoxelGrid& lattice, int side, double margin,
                    std::vector<Block>& found) {
  for (const auto& z : halves(block, 2, side))
    for (const auto& y : halves(block, 1, side))
      for (const auto& x : halves(block, 0, side)) {
        Block child{{x[0], y[0], z[0]}, {x[1], y[1], z[1]}, false, {}};
        const Vec3 low = lattice.node(x[0], y[0], z[0]);
        const Vec3 high = lattice.node(x[1] - 1, y[1] - 1, z[1] - 1);
        const Vec3 centre = 0.5 * (low + high);
        const double reach = 0.5 * (high - low).norm() + margin;
        const double distance = block.solid.distance(centre);
        if (distance > reach) continue;
        child.inside = distance < -reach;
        if (!child.inside) child.solid = block.solid.near(centre, reach);
        split(child, lattice, side, margin, found);
      }
}

void split(const Block& block, const VoxelGrid& lattice, int side, double margin,
           std::vector<Block>& found) {
  if (block.inside || single_block(block, side))
    found.push_back(block);
  else
    split_children(block, lattice, side, margin, found);
}

void fill_block(const Block& block, const VoxelGrid& lattice, std::vector<std::uint8_t>& voxels) {
  for (int k = block.low[2]; k < block.high[2]; ++k)
    for (int j = block.low[1]; j < block.high[1]; ++j)
      for (int i = block.low[0]; i < block.high[0]; ++i) {
        const std::size_t row = static_cast<std::size_t>(lattice.size[1]) * k + j;
        if (block.inside || block.solid.distance(lattice.node(i, j, k)) < 0)
          voxels[row * lattice.size[0] + i] = 1;
      }
}

void draw_point(const Vec3& p, const VoxelGrid& lattice, std::vector<std::uint8_t>& voxels) {
  const Vec3 index = (p - lattice.start).cwiseQuotient(lattice.step);
  const auto i = static_cast<int>(std::floor(index[0] + 0.5));
  const auto j = static_cast<int>(std::floor(index[1] + 0.5));
  const auto k = static_cast<int>(std::floor(index[2] + 0.5));
  if (i < 0 || j < 0 || k < 0) return;
  if (i >= lattice.size[0] || j >= lattice.size[1] || k >= lattice.size[2]) return;
  voxels[(static_cast<std::size_t>(lattice.size[1]) * k + j) * lattice.size[0] + i] = 1;
}

}  // namespace

std::vector<Block> find_blocks(const Shape& solid, const VoxelGrid& lattice, int side,
                               double margin) {
  std::vector<Block> found;
  split_children({{0, 0, 0}, lattice.size, false, solid}, lattice, side, margin, found);
  return found;
}

void voxelise(const Shape& solid, const VoxelGrid& lattice, std::vector<std::uint8_t>& voxels) {
  const std::vector<Block> blocks = find_blocks(solid, lattice, kVoxelBlock, 0);
  const auto fill = [&](std::size_t b) { fill_block(blocks[b], lattice, voxels); };
  tbb::parallel_for(std::size_t{0}, blocks.size(), TaskOrder().around(fill));
}

void draw_line(const std::vector<Vec3>& points, const VoxelGrid& lattice,
               std::vector<std::uint8_t>& voxels) {
  const double step = 0.25 * lattice.step.minCoeff();
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vec3 way = points[i + 1] - points[i];
    const int count = 1 + static_cast<int>(way.norm() / step);
    for (int n = 0; n <= count; ++n)
      draw_point(points[i] + way * (static_cast<double>(n) / count), lattice, voxels);
  }
}

}  // namespace vasamesh::phantom

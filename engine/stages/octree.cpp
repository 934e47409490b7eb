#include "stages/octree.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "backend/in_steps.h"
#include "stages/bricks.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

/// The octant of a parent that a brick fills.
std::uint8_t octant_bit(const BrickCoord& c) {
  return static_cast<std::uint8_t>(1u << ((c.x & 1) | (c.y & 1) << 1 | (c.z & 1) << 2));
}

/// The bricks of the next coarser level that hold the bricks given and four cells round them.
std::vector<BrickCoord> coarser_bricks(Backend& backend, const std::vector<BrickCoord>& bricks) {
  std::vector<BrickCoord> parents(bricks.size());
  std::vector<std::uint8_t> octants(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    parents[i] = {bricks[i].x >> 1, bricks[i].y >> 1, bricks[i].z >> 1};
    octants[i] = octant_bit(bricks[i]);
  }
  return dilate_by_octants(backend, parents, octants);
}

/// The refined bricks round the samples that want them: those of vessels thinner than `thickness`.
std::vector<BrickCoord> refined_bricks(Backend& backend, const PointCloud& points,
                                       float thickness) {
  const PointView view = points.view();
  backend.on_host(view.thickness);
  for (const View<const float>& axis : view.position) backend.on_host(axis);
  std::vector<BrickCoord> bricks;
  std::vector<std::uint8_t> octants;
  in_steps(backend, view.count, [&](std::size_t i) {
    if (view.thickness[i] >= thickness) return;
    int cell[3];
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<int>(std::floor(2.0f * view.position[axis][i]));
    const BrickCoord brick = {cell[0] >> 3, cell[1] >> 3, cell[2] >> 3};
    const int octant = (cell[0] >> 2 & 1) | (cell[1] >> 2 & 1) << 1 | (cell[2] >> 2 & 1) << 2;
    if (bricks.empty() || !(bricks.back() == brick)) {
      bricks.push_back(brick);
      octants.push_back(0);
    }
    octants.back() = static_cast<std::uint8_t>(octants.back() | 1u << octant);
  });
  return dilate_by_octants(backend, bricks, octants);
}

OctreeLevel make_level(Backend& backend, int exponent, const Scale& scale,
                       std::vector<BrickCoord> coords) {
  OctreeLevel level;
  level.exponent = exponent;
  level.coords = std::move(coords);
  level.bricks = make_bricks(backend, level.coords);
  const float cell = std::ldexp(1.0f, exponent);
  const float side[3] = {scale[0] * cell, scale[1] * cell, scale[2] * cell};
  level.weights = {side[1] * side[2] / side[0], side[0] * side[2] / side[1],
                   side[0] * side[1] / side[2]};
  const std::size_t cells = level.bricks.count * kBrickCells;
  level.unknown = Buffer<std::uint8_t>(backend, cells);
  level.right_hand_side = Buffer<float>(backend, cells);
  level.solution = Buffer<float>(backend, cells);
  return level;
}

bool is_root(const std::vector<BrickCoord>& coords) {
  return std::all_of(coords.begin(), coords.end(), [](const BrickCoord& c) {
    return c.x >= -1 && c.x <= 1 && c.y >= -1 && c.y <= 1 && c.z >= -1 && c.z <= 1;
  });
}

void require_depth(const Parameters& parameters, int regular_depth) {
  if (parameters.depth == 0) return;
  if (parameters.depth >= regular_depth - 2 && parameters.depth <= regular_depth + 1) return;
  throw Error(ErrorCode::usage, "--depth is out of its range for this volume: give " +
                                    std::to_string(regular_depth - 2) + " to " +
                                    std::to_string(regular_depth + 1) + " (one cell a voxel is " +
                                    std::to_string(regular_depth) + "), or 0 for automatic");
}

}  // namespace

std::size_t OctreeBricks::count() const {
  std::size_t sum = 0;
  for (const std::vector<BrickCoord>& level : levels) sum += level.size();
  return sum;
}

OctreeBricks octree_bricks(Backend& backend, const PointCloud& points,
                           const Parameters& parameters) {
  std::vector<BrickCoord> with_points(points.bricks.count);
  std::vector<std::uint8_t> octants(points.bricks.count);
  backend.download<BrickCoord>(points.bricks.coords.view(), with_points);
  backend.download<std::uint8_t>(points.octants.view(), octants);

  OctreeBricks bricks;
  bricks.levels = {dilate_by_octants(backend, with_points, octants)};
  while (bricks.levels.size() < 3 || !is_root(bricks.levels.back()))
    bricks.levels.push_back(coarser_bricks(backend, bricks.levels.back()));
  std::reverse(bricks.levels.begin(), bricks.levels.end());
  bricks.root_exponent = static_cast<int>(bricks.levels.size()) - 1;
  require_depth(parameters, 4 + bricks.root_exponent);
  const bool everywhere = parameters.depth == 4 + bricks.root_exponent + 1;
  if (parameters.depth == 0 || everywhere) {
    auto refined = refined_bricks(backend, points, everywhere ? 2.0f : kThinThickness);
    if (!refined.empty()) bricks.levels.push_back(std::move(refined));
  }
  return bricks;
}

Octree build_octree(Backend& backend, const OctreeBricks& bricks, const Scale& scale) {
  Octree octree;
  for (std::size_t i = 0; i < bricks.levels.size(); ++i)
    octree.levels.push_back(
        make_level(backend, bricks.root_exponent - static_cast<int>(i), scale, bricks.levels[i]));
  for (std::size_t i = 0; i < octree.levels.size(); ++i) {
    OctreeLevel& level = octree.levels[i];
    backend.octree_mark_unknown(level.view(), i == 0, level.unknown.view());
    if (i == 0) continue;
    std::vector<BrickCoord> corners = level.coords;
    for (BrickCoord& c : corners) c = {(c.x >> 1) - 1, (c.y >> 1) - 1, (c.z >> 1) - 1};
    level.parents = brick_windows(backend, corners, 3, octree.levels[i - 1].coords);
  }
  return octree;
}

LevelPoints index_points(Backend& backend, const OctreeLevel& level, const PointCloud& points) {
  const auto scaled = [&](int c) {
    return level.exponent < 0 ? c >> -level.exponent : c * (1 << level.exponent);
  };
  std::vector<BrickCoord> with_points(points.bricks.count);
  backend.download<BrickCoord>(points.bricks.coords.view(), with_points);
  std::vector<BrickCoord> corners = level.coords;
  for (BrickCoord& c : corners) c = {scaled(c.x) - 1, scaled(c.y) - 1, scaled(c.z) - 1};
  LevelPoints index;
  index.side = std::max(1, 1 << std::max(level.exponent, 0)) + 2;
  index.bricks = brick_windows(backend, corners, index.side, with_points);
  index.voxel_start = points.voxel_start.view();
  return index;
}

}  // namespace vasamesh

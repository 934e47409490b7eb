#pragma once

/// \file
/// The adaptive octree of the samples (Section "Indicator function" of the paper; Kazhdan, Bolitho
/// and Hoppe, "Poisson surface reconstruction", 2006), as levels of bricks: one cell a voxel round
/// every sample, half a voxel where the vessel is thin, and coarser bands above them to the root.

#include "backend/backend.h"
#include "types/octree.h"
#include "types/point_cloud.h"
#include "vasamesh/parameters.h"

namespace vasamesh {

/// Samples of less thickness than this get the refined level.
inline constexpr float kThinThickness = 0.5f;

/// The bricks of an octree's levels, the root's first.
struct OctreeBricks {
  int root_exponent = 0;
  std::vector<std::vector<BrickCoord>> levels;

  std::size_t count() const;  ///< of all levels
};

/// Those that the samples need. With parameters.depth one above the regular depth the refined level
/// covers every sample.
/// \throws Error usage, when parameters.depth is not within two below and one above the regular
///         depth, which the message names.
OctreeBricks octree_bricks(Backend& backend, const PointCloud& points,
                           const Parameters& parameters);

/// Levels, parents and unknown cells; no values yet.
Octree build_octree(Backend& backend, const OctreeBricks& bricks, const Scale& scale);

inline Octree build_octree(Backend& backend, const PointCloud& points, const Scale& scale,
                           const Parameters& parameters) {
  return build_octree(backend, octree_bricks(backend, points, parameters), scale);
}

/// The points near the bricks of a level (of exponent 1 at most).
struct LevelPoints {
  int side = 3;
  Buffer<std::int32_t> bricks;
  View<const std::uint32_t> voxel_start;

  PointIndex view() const { return {side, bricks.view(), voxel_start}; }
};
LevelPoints index_points(Backend& backend, const OctreeLevel& level, const PointCloud& points);

}  // namespace vasamesh

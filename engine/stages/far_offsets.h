#pragma once

/// \file
/// Where the test for labels that are too far from the segmentation looks round a node
/// (Backend::lattice_mark_far), for every backend.

#include <array>
#include <vector>

#include "types/point_cloud.h"

namespace vasamesh {

inline constexpr float kFarEnough = 0.35f;  ///< limits: a surface so near a face is near enough

/// An offset in nodes and its length in voxel lengths.
struct FarOffset {
  int x, y, z;
  float length;
  int edge;  ///< 1 when an edge of the lattice leads there
};

struct FarOffsets {
  /// Those at which the surface is looked for round a node, none farther than three nodes along an
  /// axis: the lattice's edges, and what lies within the limit. Shortest first, as all of these.
  std::vector<FarOffset> beside;
  /// Those searched for crossings and face centres, none farther than six nodes along an axis.
  std::vector<FarOffset> search;
  std::array<float, 7> edge_length{};  ///< of the edges along bit masks 1..7
};

/// \param limit  voxel lengths.
FarOffsets make_far_offsets(const Scale& scale, float limit);

/// How many octants of bricks along each axis, 1 or 2, a value or label lies at most from the nodes
/// whose test it takes part in.
std::array<int, 3> far_reach(const FarOffsets& offsets);

}  // namespace vasamesh

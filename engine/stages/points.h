#pragma once

/// \file
/// Point extraction (Section "Point extraction" of the paper; Schumann et al., "Model-free surface
/// visualization of vascular trees", EuroVis 2007): samples of the vessel boundary from the
/// constellation of object voxels round each outer boundary voxel.
///
/// An outer boundary voxel is background with an object 6-neighbour. The mask of its six object
/// neighbours decides:
///  - no two of them opposite: one point, the mean of the centres of the shared faces, with the sum
///    of their outward area vectors;
///  - two opposite (two sheets meet in the voxel): one point a face.
/// Outer boundary voxels next to thin structures are split into 2 x 2 x 2 subvoxels, each with at
/// most one object neighbour an axis, and each gives one point by the first rule. (The paper moves
/// no area along; the area vectors make the density of the samples known.)
///
/// Order of points: brick, voxel in the brick (brick_cell), then subvoxel sx + 2 sy + 4 sz, or face
/// -x, +x, -y, +y, -z, +z.

#include <array>
#include <cstdint>

#include "backend/backend.h"
#include "types/point_cloud.h"
#include "types/volume.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Bits of a neighbour mask: bit 2 axis + side, side 0 below and 1 above.
inline constexpr int kNeighbourMasks = 64;

/// True when the mask holds two opposite neighbours.
constexpr bool has_opposite_pair(unsigned mask) { return (mask & (mask >> 1) & 0b010101u) != 0; }

/// The part of a mask that a subvoxel sx + 2 sy + 4 sz shares faces with.
constexpr unsigned subvoxel_mask(unsigned mask, unsigned subvoxel) {
  unsigned facing = 0;
  for (unsigned axis = 0; axis < 3; ++axis) facing |= 1u << (2 * axis + (subvoxel >> axis & 1u));
  return mask & facing;
}

/// How many points a voxel with this mask gives.
constexpr unsigned point_count(unsigned mask, bool refined) {
  unsigned count = 0;
  if (refined) {
    for (unsigned s = 0; s < 8; ++s) count += subvoxel_mask(mask, s) != 0;
    return count;
  }
  if (!has_opposite_pair(mask)) return mask != 0;
  for (; mask != 0; mask &= mask - 1) ++count;
  return count;
}

/// point_count for all masks: [refined][mask].
using PointCounts = std::array<std::array<std::uint8_t, kNeighbourMasks>, 2>;
constexpr PointCounts make_point_counts() {
  PointCounts counts{};
  for (unsigned mask = 0; mask < kNeighbourMasks; ++mask)
    for (unsigned refined = 0; refined < 2; ++refined)
      counts[refined][mask] = static_cast<std::uint8_t>(point_count(mask, refined != 0));
  return counts;
}
inline constexpr PointCounts kPointCounts = make_point_counts();

/// mm: the geometric mean of the three spacings.
double voxel_length(const Geometry& geometry);

/// spacing / voxel_length().
Scale make_scale(const Geometry& geometry);

/// The volume bit-packed, with kPad background voxels before it, at least as many after, and each
/// size a multiple of 8. \throws Error bad_input, when a size is below 1 or absurd.
BitVolume pack_volume(Backend& backend, const VolumeView& volume);

/// All of the point cloud but its normals.
PointCloud extract_points(Backend& backend, const BitVolume& object, const Scale& scale);

}  // namespace vasamesh

#pragma once

/// \file
/// Oriented samples of the vessel boundary, in flat arrays, sorted by the brick of their voxel,
/// then by voxel, then by their place in it.
///
/// Positions are in padded voxel units: voxel (x, y, z) of the padded volume is the box from
/// (x, y, z) to (x + 1, y + 1, z + 1).
/// Directions, areas and lengths are physical, in units of the voxel length (the geometric mean of
/// the three spacings): multiply an index offset by `scale` first.

#include <array>
#include <cstdint>

#include "types/bricks.h"
#include "types/buffer.h"

namespace vasamesh {

/// spacing / geometric mean of the spacings, along x, y, z.
using Scale = std::array<float, 3>;

/// Views of a point cloud; `Float` is float or const float.
template <class Float>
struct BasicPointView {
  std::size_t count = 0;
  std::array<View<Float>, 3> position;  ///< padded voxel units
  std::array<View<Float>, 3> area;      ///< outward area vector of the faces behind the point
  std::array<View<Float>, 3> normal;    ///< outward, unit length
  View<Float> thickness;                ///< 0 where the vessel is thin to 1 where it is thick
};
using PointView = BasicPointView<const float>;
using PointOutput = BasicPointView<float>;

struct PointCloud {
  std::size_t count = 0;
  std::size_t thin_count = 0;  ///< those that come from refined voxels, next to thin structures
  std::array<Buffer<float>, 3> position, area, normal;
  Buffer<float> thickness;

  /// The bricks (of 8 x 8 x 8 voxels) that hold the points' voxels, and for each voxel of each
  /// brick the first of its points: those of voxel v of brick b are the points from
  /// voxel_start[512 b + v] up to voxel_start[512 b + v + 1].
  Bricks bricks;
  Buffer<std::uint32_t> voxel_start;  ///< 512 * bricks.count + 1 entries
  Buffer<std::uint8_t> octants;       ///< which of a brick's 8 octants (4 x 4 x 4) hold points

  PointView view() const;
  PointOutput output();
};

/// The points near each brick of a level, for passes that gather from points: `bricks` holds, for
/// each brick B of a level of exponent e, the point cloud's bricks from floor(B 2^e) - 1 on,
/// side = max(1, 2^e) + 2 along each axis, x fastest, kNoBrick where there is none.
struct PointIndex {
  int side = 3;
  View<const std::int32_t> bricks;
  View<const std::uint32_t> voxel_start;
};

/// Knot distance of the splatting B-spline, in voxel lengths: `thin` up to a thickness of a
/// quarter, `thick` from three quarters on, blended between.
struct Kernel {
  float thin = 1, thick = 1;

  float at(float thickness) const {
    const float blend = 2.0f * thickness - 0.5f;
    return thin + (thick - thin) * (blend < 0 ? 0.0f : blend > 1 ? 1.0f : blend);
  }
};

inline PointView PointCloud::view() const {
  return {count,
          {position[0].view(), position[1].view(), position[2].view()},
          {area[0].view(), area[1].view(), area[2].view()},
          {normal[0].view(), normal[1].view(), normal[2].view()},
          thickness.view()};
}

inline PointOutput PointCloud::output() {
  return {count,
          {position[0].view(), position[1].view(), position[2].view()},
          {area[0].view(), area[1].view(), area[2].view()},
          {normal[0].view(), normal[1].view(), normal[2].view()},
          thickness.view()};
}

}  // namespace vasamesh

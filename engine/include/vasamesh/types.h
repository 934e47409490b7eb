#pragma once

/// \file
/// The data that crosses the public edge: the caller's volume and the surface that comes back.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vasamesh {

/// Where the voxels of a volume lie in physical space, in ITK's convention (LPS, millimetres):
/// the centre of voxel (i, j, k) is origin + direction * (spacing * (i, j, k)).
struct Geometry {
  /// Voxels along i, j, k, 1 to 2^20 each; i varies fastest.
  std::array<std::int64_t, 3> size{0, 0, 0};
  /// mm, 1e-6 to 1e4 each, the largest at most 100 times the smallest.
  std::array<double, 3> spacing{1, 1, 1};
  /// mm, LPS, centre of voxel (0, 0, 0).
  std::array<double, 3> origin{0, 0, 0};
  /// Row-major; orthonormal columns, their products within 0.001; determinant -1 mirrors.
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// How a VolumeView holds its voxels.
enum class VoxelFormat {
  bytes,  ///< one uint8 (or bool) a voxel; nonzero is object
  bits,   ///< one bit a voxel, least significant first, each row of i padded to a whole byte
};

/// A binary segmentation in the caller's memory, not owned. Voxel (i, j, k) of a `bytes` volume is
/// data[i + size[0] * (j + size[1] * k)].
struct VolumeView {
  const void* data = nullptr;
  VoxelFormat format = VoxelFormat::bytes;
  Geometry geometry;
};

/// A triangle surface, flat. Vertices in mm, float32, in the space that the parameters ask for
/// (LPS by default); triangles are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<float> vertices;           ///< x0 y0 z0 x1 y1 z1 ...
  std::vector<std::uint32_t> triangles;  ///< a0 b0 c0 a1 b1 c1 ..., indices of vertices

  std::size_t vertex_count() const { return vertices.size() / 3; }
  std::size_t triangle_count() const { return triangles.size() / 3; }

  bool operator==(const TriangleMesh&) const = default;
};

}  // namespace vasamesh

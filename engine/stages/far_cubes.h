#pragma once

/// \file
/// What the test for labels that are too far from the segmentation asks of marching cubes
/// (Backend::lattice_mark_far; types/marching_cube.h), for every backend.

#include <array>
#include <cstdint>
#include <vector>

#include "types/point_cloud.h"

namespace vasamesh {

/// Two or three corners of a polygon. The surface is looked for round their middle. Lengths in
/// voxel lengths.
struct FarPart {
  std::int32_t count;
  std::array<std::int32_t, 3> face;  ///< of kCubeFaces
  std::array<float, 3> from_face;    ///< from them to the middle
  float from_corner;                 ///< from the cube's lattice corner
  std::array<float, 3> middle;       ///< nodes, from that corner
};

/// All pairs of a cube's faces, then all triples.
std::vector<FarPart> make_far_parts(const Scale& scale);

/// The polygons of one of the 256 cubes, by runs of the lists of FarCubes.
struct FarCube {
  std::int32_t first_part, last_part;
  std::int32_t first_side, last_side;
};

/// Voxel v of a cube lies at (v & 1, v >> 1 & 1, v >> 2 & 1), 0 for -1; the cube of a set of object
/// voxels is that of the number with their bits.
struct FarCubes {
  std::array<FarCube, 256> cubes;
  std::vector<std::uint16_t> parts;  ///< of make_far_parts(): all of each polygon
  std::vector<std::uint16_t> sides;  ///< of the polygons: a face + 16 times the other
};

const FarCubes& far_cubes();

}  // namespace vasamesh

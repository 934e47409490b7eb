#pragma once

/// \file
/// The cell lattice: nodes at the centres of voxels, faces and edges and at the corners, half a
/// voxel apart, in bricks of 8 x 8 x 8 near the segmentation's boundary. Node (x, y, z) lies at
/// (x, y, z) / 2 in padded voxel units; odd coordinates are those of voxel centres.
///
/// The Freudenthal cut divides each cube of nodes into six tetrahedra along its diagonal from
/// (0, 0, 0) to (1, 1, 1): two nodes are joined when all their differences are 0 or 1, or all 0
/// or -1. Each node has 14 neighbours, and they form a sphere (its link).

#include <array>
#include <cstdint>

#include "types/bricks.h"
#include "types/buffer.h"

namespace vasamesh {

/// Bits of a node's state.
enum LatticeBit : std::uint8_t {
  kLabel = 1,       ///< inside, as relabelled
  kSolid = 2,       ///< inside the segmentation as a solid
  kFree = 4,        ///< near enough to the boundary that the label may change
  kFaceCentre = 8,  ///< the centre of a face between object and background
};

/// Why a node is marked for repair.
enum LatticeMark : std::uint8_t {
  kFarMark = 1,    ///< the labels leave the solid too far there
  kStuckMark = 2,  ///< its flip would change the topology, and is wanted or all but
};

inline constexpr int kNodeBlock = 512;  ///< nodes of a list that a work-group takes

/// How far from zero, at least, the solid's field is at a node that keeps its label.
inline constexpr float kLeastOccupancy = 0.03f;

/// Voxels: what is narrower is led back to the segmentation (lattice_mark_narrow).
struct LeastWidths {
  float across;  ///< lines and specks
  float sheet;   ///< what is closed along one axis alone
};

/// An offset between nodes.
struct NodeOffset {
  std::int8_t x, y, z;
};

/// The 14 neighbours: offset bit masks 1..7, then their negatives.
inline constexpr std::array<NodeOffset, 14> kLink = {{{1, 0, 0},
                                                      {0, 1, 0},
                                                      {1, 1, 0},
                                                      {0, 0, 1},
                                                      {1, 0, 1},
                                                      {0, 1, 1},
                                                      {1, 1, 1},
                                                      {-1, 0, 0},
                                                      {0, -1, 0},
                                                      {-1, -1, 0},
                                                      {0, 0, -1},
                                                      {-1, 0, -1},
                                                      {0, -1, -1},
                                                      {-1, -1, -1}}};

struct Lattice {
  Bricks bricks;
  Buffer<std::uint8_t> state;  ///< a node: LatticeBits
  Buffer<float> values;        ///< a node: the indicator function minus its local isovalue
  float limit = 1;             ///< voxel lengths: how far the surface may be from the solid's
                               ///< marching cubes
};

}  // namespace vasamesh

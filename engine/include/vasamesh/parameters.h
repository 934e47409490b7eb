#pragma once

/// \file
/// The user's constants, with their defaults and ranges.

#include <cstdint>

namespace vasamesh {

/// How point normals are estimated (Section "Normal vector estimation" of the paper).
enum class NormalMode {
  covariance,  ///< covariance of the k nearest neighbours, oriented by the occupancy (the paper's)
  gradient,    ///< gradient of the Gaussian-smoothed occupancy
};

/// Which contacts join two voxels into one piece.
enum class Connectivity : int {
  face = 6,     ///< a shared face
  edge = 18,    ///< a shared face or edge
  vertex = 26,  ///< a shared face, edge or corner: the segmentation as a union of closed voxels
};

/// The space of the vertices that come out.
enum class Space {
  lps,    ///< ITK's physical space, the default
  ras,    ///< x and y change sign against lps
  voxel,  ///< mm along the volume's own axes, from the centre of voxel (0, 0, 0)
};

/// Everything that a conversion may be asked. One kernel-width unit, and every "voxel" below, is
/// the geometric mean of the three spacings.
struct Parameters {
  int neighbours = 10;          ///< k of the covariance normals, 3 to 64
  NormalMode normals = NormalMode::covariance;
  int depth = 0;                ///< depth of the octree's finest regular level; 0: one cell a voxel.
                                ///< Otherwise from two below that to one above it.
  double kernel_width = 1.66;   ///< knot distance of the splatting B-spline where the vessel is
                                ///< thick, in voxels, 0.5 to 4: the smoothing knob
  Connectivity connectivity = Connectivity::vertex;
  bool close_handles = false;   ///< fill tunnels and cavities that the smooth field does not have
  std::int64_t min_component = 0;  ///< drop pieces of fewer voxels; 0 keeps all
  Space space = Space::lps;
  std::int64_t max_memory = 0;  ///< bytes that the conversion may hold; 0: no limit
};

/// Throws Error(usage), naming the field and its range, when a parameter is outside it.
void validate(const Parameters& parameters);

}  // namespace vasamesh

#pragma once

/// \file
/// The user's constants, with their defaults and ranges.

#include <cstdint>
#include <string>

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

/// Which triangles come out.
enum class SurfaceKind {
  adaptive,  ///< sizes that follow the curvature, close to equilateral
  base,      ///< those of the cell lattice: about twelve times as many as marching cubes gives
};

/// How the triangulation of a gap is chosen among those that obey the rules.
enum class StitchMode {
  /// The paper's single pass by (alpha, beta, A): the largest least angle, then the smallest
  /// largest dihedral angle, then the least area. The pass is exact in alpha alone: beta of a part
  /// depends on what the part is joined to.
  paper,
  /// Two passes: the largest least angle alpha, then the least total cost over all triangulations
  /// that reach it. Both exact.
  exact,
};

/// How long the edges of the adaptive surface are to be, at a point of radius of curvature r:
/// clamp(rho r, edge_min, edge_max), never above 1.25 r, and growing by at most `gradation` a
/// length. At most one of edges_around, chord_error and triangles may be given; it takes the place
/// of rho.
struct EdgeLengths {
  /// Voxels: lengths that may be asked for, or that a number of triangles may need.
  static constexpr double kLeastEdge = 0.1, kLongestEdge = 100;

  double rho = 0.6;            ///< edge length over radius of curvature, 0.001 to 2
  double edges_around = 0;     ///< edges round a vessel, 4 to 100: rho = 2 pi / edges_around
  double chord_error = 0;      ///< voxels, 0.001 to 1: sqrt(8 chord_error r) instead of rho r
  std::int64_t triangles = 0;  ///< how many are wanted, within 10 %, at most 10^9: rho,
                               ///< edge_min and edge_max are scaled together
  double edge_min = 1.1;       ///< voxels, kLeastEdge to kLongestEdge
  double edge_max = 1.6;       ///< voxels, edge_min to kLongestEdge
  double gradation = 0.25;     ///< 0.01 to 2
};

/// Everything that a conversion may be asked. One kernel-width unit, and every "voxel" below, is
/// the geometric mean of the three spacings.
struct Parameters {
  /// Voxels: kernel widths that may be asked for.
  static constexpr double kLeastKernel = 0.5, kWidestKernel = 4;

  int neighbours = 10;  ///< k of the covariance normals, 3 to 64
  NormalMode normals = NormalMode::covariance;
  int depth = 0;               ///< depth of the octree's finest regular level; 0: one cell a voxel.
                               ///< Otherwise from two below that to one above it.
  double kernel_width = 1.66;  ///< knot distance of the splatting B-spline where the vessel is
                               ///< thick, in voxels, kLeastKernel to kWidestKernel: the
                               ///< smoothing knob. Above the default the surface may leave the
                               ///< segmentation in proportion farther (Report::distance_limit).
  Connectivity connectivity = Connectivity::vertex;
  bool close_handles = false;  ///< fill tunnels and cavities that the smooth field does not have
  SurfaceKind surface = SurfaceKind::adaptive;
  EdgeLengths edges;  ///< of the adaptive surface
  StitchMode stitch = StitchMode::exact;
  std::int64_t min_component = 0;  ///< drop pieces of fewer voxels; 0 keeps all
  Space space = Space::lps;
  /// Bytes of the stages' buffers, which the report counts, that may be held at once; 0: no limit.
  /// What the mesh stages keep in lists of their own is not counted.
  std::int64_t max_memory = 0;
};

/// Sets edges and stitch by a name: "default"; "paper" (edges of about a voxel everywhere, which
/// the triangle counts of the paper's Table 3 correspond to, and its single pass); "simulator"
/// (fewer and larger triangles). \throws Error usage for another name.
void set_preset(const std::string& name, Parameters& parameters);

/// Throws Error(usage), naming the program's option for the field and its range, when a parameter
/// is outside it.
void validate(const Parameters& parameters);

}  // namespace vasamesh

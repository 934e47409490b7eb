#pragma once

/// \file
/// What a conversion says about its input, its work and its surface: plain data, no formatting.
/// The program writes it as JSON (host/io), see docs/report.md for the schema.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// A count of something found in the input, and where the first one is.
struct Finding {
  std::int64_t count = 0;
  std::array<std::int64_t, 3> place{-1, -1, -1};  ///< a voxel (i, j, k); -1 when count is 0
};

/// One piece of a solid: a connected component of the segmentation under its connectivity.
struct Piece {
  std::int64_t voxels = 0;
  std::array<std::int64_t, 3> first_voxel{0, 0, 0};  ///< the first in raster order
  std::int64_t cavities = 0;  ///< b2: enclosed voids that this piece bounds from outside
  std::int64_t handles = 0;   ///< b1: independent tunnels; the genus sum of the piece's shells
};

/// Betti numbers of the segmentation, from counting cells, and the same of a surface.
struct Topology {
  std::int64_t pieces = 0;    ///< b0; outward shells
  std::int64_t handles = 0;   ///< b1; sum of the shells' genus
  std::int64_t cavities = 0;  ///< b2; inward shells

  bool operator==(const Topology&) const = default;
};

/// What was found in the segmentation.
struct InputFindings {
  std::int64_t object_voxels = 0;
  std::vector<Piece> pieces;  ///< in raster order of their first voxels
  Finding specks;             ///< pieces of fewer than 8 voxels
  Finding cavities;
  Finding handles;          ///< place: first voxel of the first piece that has one
  Finding edge_contacts;    ///< 2x2 configurations joined over an edge only
  Finding corner_contacts;  ///< 2x2x2 configurations joined over a corner only
  Finding border_contacts;  ///< object voxels on the volume's border
  Finding one_voxel_parts;  ///< object voxels without a 2x2x2 object block around them
  double anisotropy = 1;    ///< largest spacing / smallest spacing
  /// Voxels along each axis of the blocks over which the labels are constant: above 1 where they
  /// were enlarged.
  std::array<std::int64_t, 3> blocks{1, 1, 1};
  Finding dropped;  ///< pieces removed by Parameters::min_component
};

/// One stage of the pipeline as it ran.
struct StageReport {
  std::string name;
  std::string backend;
  std::string device;
  double seconds = 0;
  double device_seconds = 0;    ///< of these, in which the program waited for the device
  std::int64_t bytes_held = 0;  ///< bytes held by the backends' buffers at the stage's end
  std::int64_t launches = 0;    ///< of a device's kernels
  std::int64_t copies = 0;      ///< to and from a device's own memory
  std::int64_t bytes_copied = 0;
  std::string other_arithmetic;  ///< what of the device's is not as specified, so that it may give
                                 ///< other bytes than the CPU; else empty
  std::string host_reason;       ///< why it ran on the CPU though there was a device; else empty
  std::string host_part;         ///< what of it ran on the CPU beside the device; else empty
  std::string failure;           ///< of the device, after which the stages were run again on the
                                 ///< CPU; empty when it did not fail
};

/// One level of the octree as it was solved.
struct LevelReport {
  int depth = 0;
  std::array<std::int64_t, 3> cells{0, 0, 0};  ///< the level's full extent, in cells
  std::int64_t nodes = 0;                      ///< active cells
  std::int64_t leaves = 0;                     ///< active cells without active children
  int iterations = 0;
  double initial_residual = 0;  ///< 2-norm, relative to the right-hand side's
  double residual = 0;
};

/// How far the relabelled field had to be led back to the segmentation (engine/stages/relabel.h).
struct RelabelReport {
  std::int64_t lattice_nodes = 0;
  std::int64_t flips = 0;
  std::int64_t stuck_first = 0;  ///< nodes whose flip would have changed the topology, first pass
  std::int64_t clamped = 0;      ///< nodes that kept their label against the repaired field
  int repair_passes = 0;
  std::int64_t handles_closed = 0;
  std::int64_t cavities_closed = 0;
};

/// How the adaptive surface was made (engine/stages/polygonize.h); of the attempt that was taken.
struct MeshReport {
  double predicted_triangles = 0;    ///< before meshing, from the sizes
  int attempts = 0;                  ///< surfaces that were made until one was proven
  int rounds = 0;                    ///< of the front
  double hard_share = 0;             ///< of the area: remeshed from the base surface
  double base_share = 0;             ///< of the area: the base surface as it is
  std::int64_t front_triangles = 0;  ///< that the front added
  std::int64_t gaps = 0;             ///< that it left
  std::int64_t gap_triangles = 0;    ///< that closed them
  std::int64_t far_points = 0;       ///< of marching cubes or of the surface: left farther from
                                     ///< the other than 0.93 or 0.97 of Report::distance_limit
};

/// A distribution in a few numbers.
struct Distribution {
  double mean = 0, deviation = 0, minimum = 0, percentile_5 = 0, median = 0, percentile_95 = 0,
         maximum = 0;
};

/// The quality of a surface's triangles.
struct QualityReport {
  Distribution edge_ratio;         ///< tau = shortest edge / longest edge of a triangle
  double edge_ratio_above_08 = 0;  ///< fraction of triangles with tau >= 0.8
  double edge_ratio_below_03 = 0;
  double edge_ratio_below_01 = 0;
  Distribution least_angle;      ///< degrees, of a triangle
  double edges_within_15 = 0;    ///< fraction of the pairs of a triangle's edges, longer / shorter
                                 ///< at most 1.5; every such pair shares a vertex
  Distribution edge_length;      ///< mm, of the edges that two triangles share
  Distribution size_ratio;       ///< longer / shorter mean edge of two triangles that share an edge
  Distribution dihedral_angle;   ///< degrees, between two triangles that share an edge, on the side
                                 ///< where it is less: 180 where they lie in one plane
  std::int64_t sharp_edges = 0;  ///< edges with a dihedral angle below 60 degrees
  double area = 0;               ///< mm^2
  double volume = 0;             ///< mm^3, signed: positive when outward
};

/// Whether a surface is one that a solver can take. See engine/stages/verify.h.
struct CheckReport {
  std::int64_t vertices = 0, triangles = 0;
  std::int64_t open_edges = 0;            ///< edges of one triangle
  std::int64_t nonmanifold_edges = 0;     ///< edges of three or more triangles
  std::int64_t misoriented_edges = 0;     ///< edges that both triangles traverse the same way
  std::int64_t nonmanifold_vertices = 0;  ///< vertices whose triangles are not one fan
  std::int64_t isolated_vertices = 0;     ///< vertices of no triangle
  std::int64_t degenerate_triangles = 0;  ///< of zero area, or with a repeated vertex
  std::int64_t nonfinite_vertices = 0;
  std::int64_t intersecting_pairs = 0;    ///< pairs of triangles that meet beyond shared vertices
  std::int64_t inverted_shells = 0;       ///< shells that face the wrong way for their nesting
  Topology topology;                      ///< of the surface
  std::vector<std::int64_t> shell_genus;  ///< a shell an entry, in order of lowest triangle
  bool has_wanted = false;                ///< a segmentation was given
  Topology wanted;                        ///< of the segmentation
  std::int64_t mismatched_pieces = 0;     ///< pieces whose shells or genus differ from the solid's
  bool passed = false;                    ///< all of the above is as it must be
  std::string reason;                     ///< why not, empty when passed
};

/// Everything a conversion reports. Schema version 1.
struct Report {
  static constexpr int kSchemaVersion = 1;
  Geometry geometry;
  Parameters parameters;
  InputFindings input;
  std::int64_t points = 0;
  std::int64_t thin_points = 0;    ///< points from refined subvoxels
  std::int64_t bytes_planned = 0;  ///< the most that the work was expected to hold
  double distance_limit = 0;       ///< mm: how far the surface and the segmentation's marching
                                   ///< cubes may be from each other
  std::vector<StageReport> stages;
  std::vector<LevelReport> levels;  ///< coarse to fine
  RelabelReport relabel;
  MeshReport mesh;
  CheckReport check;
  QualityReport quality;
};

}  // namespace vasamesh

#pragma once

/// \file
/// The indicator function: the Poisson equation of the splatted normals (eq. 2 to 4 of the paper)
/// solved level by level, and the local isovalue taken off, so that the surface is its zero set.
///
/// The field is a sum of quadratic B-splines on the cells of a level. Each level starts from the
/// coarser one's field, which subdivision represents exactly, and keeps it where its band ends.

#include "backend/backend.h"
#include "scheduler.h"
#include "stages/octree.h"
#include "types/octree.h"
#include "types/point_cloud.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"

namespace vasamesh {

/// Conjugate gradient iterations: at the root, and at the other levels. The band's boundary values
/// come from the coarser level, so that more change little: the base surface lies .005 voxel on
/// average from that after 60 iterations a level (docs/performance.md).
inline constexpr int kRootIterations = 40;
inline constexpr int kLevelIterations = 12;

/// Knot distance of the splatting kernel where the vessel is thin, in voxel lengths. Where slices
/// are so thick that the other two spacings are less than kFineSpacing voxel lengths, the kernel
/// shrinks with the square of the larger: vessels lose volume to one that is wide beside their
/// pixels (a coil of a tube of 1.5 voxels, in slices of six pixels, 23 % to one of a voxel, 17 %
/// so).
inline constexpr float kThinKernel = 1.0f, kFineSpacing = 0.8f;

/// Standard deviations of the local isovalue's kernels, in voxel lengths: where the vessel is
/// thick, and where it is thin, for there a mean over more lets branchings swell and draws what
/// lies between them to threads. Of the wide kernel that share stays there too: the narrow one
/// alone gives the field spikes that a front runs away on.
inline constexpr float kWideSigma = 2.0f, kNarrowSigma = 0.9f, kLeastWideShare = 0.25f;

/// Taken off beside the local isovalue: samples in the concave corners of the voxels' steps lie
/// outside by 0.01 to 0.02 voxel on average, measured on shapes of known volume.
inline constexpr float kOutwardBias = 0.005f;

/// Arrays of a solve, kept from level to level: a solve allocates nothing where they are large
/// enough.
struct SolveWorkspace {
  void resize(Backend& backend, std::size_t bricks);

  Buffer<float> residual, direction, partial, partial_b;
};

/// Iterations done and the 2-norm of the residual before and after, relative to that of b.
struct SolveOutcome {
  int iterations = 0;
  double initial_residual = 0;
  double residual = 0;
};

/// Solves A x = b on the unknown cells of a level by conjugate gradients from the x given
/// (Hestenes and Stiefel, 1952). Ends early where the residual falls below 1e-6 of b.
SolveOutcome conjugate_gradient(Backend& backend, const LevelView& level,
                                View<const std::uint8_t> unknown, View<const float> b,
                                View<float> x, int iterations, SolveWorkspace& workspace);

/// Fills right_hand_side of every level: splatted on the regular and the refined level, restricted
/// to the coarser ones.
void assemble_poisson(Backend& backend, const PointCloud& points, const Scale& scale,
                      const Parameters& parameters, Octree& octree);

/// Fills `solution` of every level, coarse to fine. Gives back `right_hand_side` and `unknown` of
/// each once it is solved: with the solver's arrays for the finest they would be the most that a
/// conversion holds.
void solve_poisson(Scheduler& scheduler, const Parameters& parameters, Octree& octree,
                   std::vector<LevelReport>& reports);

/// Takes the local isovalue off the regular and the refined level's solution: there the surface is
/// the zero set, positive inside.
void subtract_isovalue(Backend& backend, const PointCloud& points, const Scale& scale,
                       Octree& octree);

}  // namespace vasamesh

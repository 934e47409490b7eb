#pragma once

/// \file
/// How each phantom is made: a solid on a lattice of voxel centres, with lines or voxels drawn in.

#include <cstdint>
#include <optional>
#include <vector>

#include "phantom/lattice.h"
#include "phantom/phantom.h"
#include "phantom/solid.h"

namespace vasamesh::phantom {

/// Everything before voxelisation. Lengths in mm, in a frame of the recipe's own.
struct Recipe {
  VoxelGrid lattice;                     ///< the voxels' centres
  std::vector<std::uint8_t> drawn;       ///< voxels set beforehand; empty for none
  Shape solid;                           ///< voxels inside are set; empty for none
  std::vector<std::vector<Vec3>> lines;  ///< voxels along these polylines are set
  double exact_step = 0;                 ///< of the smallest spacing; 0: no exact surface
  double least_radius = 0;               ///< mm
  std::optional<Topology> topology;
};

/// The voxel that a shape is sized by.
struct Ruler {
  Vec3 spacing;
  double voxel;   ///< geometric mean of the spacings, mm
  double radius;  ///< of the vessel, mm

  Ruler(const PhantomOptions& options, double radius_voxels, const Vec3& default_spacing);
};

// shapes.cpp: tubes and spheres.
Recipe sphere_recipe(const PhantomOptions& options);
Recipe torus_recipe(const PhantomOptions& options);
Recipe helix_recipe(const PhantomOptions& options);
Recipe y_branch_recipe(const PhantomOptions& options);
Recipe aneurysm_recipe(const PhantomOptions& options);
Recipe two_tubes_recipe(const PhantomOptions& options);
Recipe cut_tube_recipe(const PhantomOptions& options);
Recipe hollow_shell_recipe(const PhantomOptions& options);
Recipe anisotropic_arch_recipe(const PhantomOptions& options);
Recipe line_axis_recipe(const PhantomOptions& options);
Recipe line_face_diagonal_recipe(const PhantomOptions& options);
Recipe line_space_diagonal_recipe(const PhantomOptions& options);

// drawn.cpp: voxel by voxel.
Recipe single_voxel_recipe(const PhantomOptions& options);
Recipe voxel_line_recipe(const PhantomOptions& options);
Recipe one_slice_recipe(const PhantomOptions& options);
Recipe full_box_recipe(const PhantomOptions& options);
Recipe speckle_recipe(const PhantomOptions& options);

// trees.cpp: grown at random.
Recipe tree_recipe(const PhantomOptions& options);
Recipe cerebral_recipe(const PhantomOptions& options);
Recipe liver_recipe(const PhantomOptions& options);
Recipe aorta_recipe(const PhantomOptions& options);

}  // namespace vasamesh::phantom

#pragma once

/// \file
/// Multi-level partition of unity implicits: an octree over the samples whose cells each hold a
/// quadric fitted to the samples round them, blended by weights that fall off with the distance.
///
/// Ohtake, Belyaev, Alexa, Turk, Seidel: Multi-level partition of unity implicits, SIGGRAPH 2003,
/// with its constants and without its sharp features, as Schumann et al. (Model-free surface
/// visualization of vascular trees, EuroVis 2007) use it on vessels: a general quadric where the
/// normals turn by 90 degrees or more, a height field of second degree elsewhere.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "samples.h"

namespace vasamesh::baselines {

///
/// The defaults are the best of tolerances from 0.1 to 0.8 and half edges from 0.125 to 1 on the
/// phantom `cerebral`: larger ones are smoother on thick vessels, and lose thin ones or add sheets
/// to them.
struct MpuOptions {
  double tolerance = 0.2;  ///< largest distance of a sample to its cell's quadric, voxels, above 0
  double least_cell = 0.125;  ///< half edge below which a cell is not split, voxels
};

/// A function that is negative inside, positive outside and about the distance near the surface.
class Mpu {
 public:
  /// \pre samples holds at least 16.
  Mpu(std::vector<Sample> samples, const MpuOptions& options);
  ~Mpu();

  double value(const Eigen::Vector3d& point) const;

  const std::vector<Sample>& samples() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace vasamesh::baselines

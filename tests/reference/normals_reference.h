#pragma once

/// \file
/// Normals as engine/stages/normals.h tells them: plain loops over all voxels and all points, in
/// double, with the library's exponential and Eigen's solver.

#include <array>
#include <cstdint>
#include <vector>

#include "support/dense_volume.h"
#include "types/point_cloud.h"

namespace vasamesh::reference {

using Vec3 = std::array<double, 3>;

double dot(const Vec3& a, const Vec3& b);
double length(const Vec3& v);
double angle_degrees(const Vec3& a, const Vec3& b);

/// Sum of weight * offset over the object voxels whose centre is within three deviations along each
/// axis, the weight a product of exp(-d^2 / 2 sigma^2) - exp(-4.5) over the axes; `position` in
/// padded voxels. Points inwards.
Vec3 occupancy_gradient(const test::DenseVolume& object, const Vec3& position, const Scale& scale,
                        double sigma);

/// One sample as the covariance sees it.
struct Sample {
  std::array<int, 3> voxel;
  std::array<float, 3> position;  ///< padded voxels
  std::array<float, 3> gradient;  ///< unit, outwards
};

/// A voxel's samples that agree with a query, at their mean.
struct Neighbour {
  std::array<float, 3> offset;  ///< voxel lengths
  float distance;               ///< squared
  std::size_t index;            ///< of the voxel's first sample
};

/// The k + 1 nearest of sample `query`, its own voxel's among them, in order; in float32, as the
/// contract states it, since equal distances are common on a lattice.
std::vector<Neighbour> nearest(const std::vector<Sample>& samples, std::size_t query,
                               const Scale& scale, int k);

/// The eigenvector by Eigen (the gradient where that is against the area), and how well it is told:
/// the gap of its eigenvalue to the next, as a part of the largest.
struct Plane {
  Vec3 normal;
  double gap;
};
Plane plane_normal(const std::vector<Neighbour>& neighbours, const Vec3& gradient,
                   const Vec3& area);

}  // namespace vasamesh::reference

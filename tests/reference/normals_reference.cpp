#include "reference/normals_reference.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "stages/normals.h"

namespace vasamesh::reference {

namespace {

constexpr int kGradientReach = 7;  // voxels, as the padding allows

bool within_reach(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(a[axis] - b[axis]) > kNeighbourReach) return false;
  return true;
}

bool agree(const Sample& a, const Sample& b) {
  return (a.gradient[0] * b.gradient[0] + a.gradient[1] * b.gradient[1]) +
             a.gradient[2] * b.gradient[2] >
         kSameSheetGradients;
}

/// The neighbour that samples first .. last - 1, those of one voxel, make.
Neighbour mean_of_agreeing(const std::vector<Sample>& samples, std::size_t first, std::size_t last,
                           const Sample& query, const Scale& scale) {
  Neighbour neighbour{{0, 0, 0}, -1, first};
  int count = 0;
  for (std::size_t i = first; i < last; ++i) {
    if (!agree(samples[i], query)) continue;
    for (int axis = 0; axis < 3; ++axis)
      neighbour.offset[axis] += samples[i].position[axis] - query.position[axis];
    ++count;
  }
  if (count == 0) return neighbour;
  for (int axis = 0; axis < 3; ++axis)
    neighbour.offset[axis] = neighbour.offset[axis] / static_cast<float>(count) * scale[axis];
  const auto& o = neighbour.offset;
  neighbour.distance = (o[0] * o[0] + o[1] * o[1]) + o[2] * o[2];
  return neighbour;
}

}  // namespace

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3& v) { return std::sqrt(dot(v, v)); }
double angle_degrees(const Vec3& a, const Vec3& b) {
  const double cosine = dot(a, b) / (length(a) * length(b));
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

Vec3 occupancy_gradient(const test::DenseVolume& object, const Vec3& position, const Scale& scale,
                        double sigma) {
  Vec3 sum{0, 0, 0};
  for (int z = 0; z < object.size[2]; ++z)
    for (int y = 0; y < object.size[1]; ++y)
      for (int x = 0; x < object.size[0]; ++x) {
        const std::array<int, 3> voxel{x, y, z};
        Vec3 offset;
        bool near = object.object(x, y, z);
        for (int axis = 0; axis < 3 && near; ++axis) {
          offset[axis] = (voxel[axis] + 0.5 - position[axis]) * scale[axis];
          near = std::fabs(offset[axis]) <= 3 * sigma &&
                 std::abs(voxel[axis] - static_cast<int>(position[axis])) <= kGradientReach;
        }
        if (!near) continue;
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis)
          weight *= std::exp(-offset[axis] * offset[axis] / (2 * sigma * sigma)) - std::exp(-4.5);
        for (int axis = 0; axis < 3; ++axis) sum[axis] += weight * offset[axis];
      }
  return sum;
}

std::vector<Neighbour> nearest(const std::vector<Sample>& samples, std::size_t query,
                               const Scale& scale, int k) {
  std::vector<Neighbour> all;
  for (std::size_t first = 0, last = 0; first < samples.size(); first = last) {
    while (last < samples.size() && samples[last].voxel == samples[first].voxel) ++last;
    if (!within_reach(samples[first].voxel, samples[query].voxel)) continue;
    const Neighbour one = mean_of_agreeing(samples, first, last, samples[query], scale);
    if (one.distance >= 0) all.push_back(one);
  }
  std::sort(all.begin(), all.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  });
  if (all.size() > static_cast<std::size_t>(k) + 1) all.resize(k + 1);
  return all;
}

Plane plane_normal(const std::vector<Neighbour>& neighbours, const Vec3& gradient,
                   const Vec3& area) {
  const Eigen::Vector3d g(gradient[0], gradient[1], gradient[2]);
  Eigen::MatrixXd p(neighbours.size(), 3);
  for (std::size_t i = 0; i < neighbours.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) p(i, axis) = neighbours[i].offset[axis];
  p.rowwise() -= p.colwise().mean().eval();
  const Eigen::Matrix3d covariance =
      p.transpose() * p / static_cast<double>(neighbours.size()) +
      kTangentWeight * (Eigen::Matrix3d::Identity() - g * g.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  Eigen::Vector3d normal = solver.eigenvectors().col(0);
  if (normal.dot(g) < 0) normal = -normal;
  const Eigen::Vector3d values = solver.eigenvalues();
  if (normal.dot(Eigen::Vector3d(area[0], area[1], area[2])) <
      -std::sqrt(kAgainstFaces) * length(area))
    normal = g;
  return {{normal[0], normal[1], normal[2]}, (values[1] - values[0]) / values[2]};
}

}  // namespace vasamesh::reference

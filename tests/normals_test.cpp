/// Normals of every backend, against plain oracles and against exact shapes.

#include "stages/normals.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nanoflann.hpp>
#include <random>

#include "reference/normals_reference.h"
#include "reference/points_reference.h"
#include "stages/jacobi.h"
#include "stages/points.h"
#include "support/backend_test.h"
#include "support/dense_volume.h"
#include "tbb/backend.h"
#include "tbb/rows.h"

namespace vasamesh {
namespace {

using reference::Vec3;
using test::DenseVolume;

constexpr Scale kCubes{1, 1, 1};
const std::array<double, 3> kCubicSpacing{1, 1, 1}, kCerebralSpacing{0.51, 0.51, 0.80};

// --- The eigenvalue solver. --------------------------------------------------------------------

Eigen::Matrix3f random_covariance(std::mt19937& random, int kind) {
  std::uniform_real_distribution<float> value(-1, 1);
  Eigen::MatrixXf p(12, 3);
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 3; ++j) p(i, j) = value(random);
  if (kind == 1) p.col(2) *= 1e-3f;                     // a plane
  if (kind == 2) p.rightCols(2) *= 1e-4f;               // a line
  if (kind == 3) p = (p * 2).array().round().matrix();  // lattice points: equal eigenvalues
  return p.transpose() * p;
}

TEST(Jacobi, AsEigensSolver) {
  std::mt19937 random(1);
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Matrix3f m = random_covariance(random, i % 4);
    float a[3][3];
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) a[j][k] = m(j, k);
    const auto least = least_eigenvector<OneLane>(a);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> theirs(m.cast<double>());
    const double largest = theirs.eigenvalues()[2];
    std::array<float, 3> values = {a[0][0], a[1][1], a[2][2]};
    std::sort(values.begin(), values.end());
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(values[j], theirs.eigenvalues()[j], 2e-6 * largest);
    const Eigen::Vector3d v(least[0], least[1], least[2]);
    EXPECT_NEAR(v.norm(), 1, 2e-6);
    EXPECT_LE((m.cast<double>() * v - values[0] * v).norm(), 4e-6 * largest);
  }
}

TEST(Jacobi, EightLanesAsOne) {
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    Row rows[3][3];
    float alone[8][3][3];
    for (int lane = 0; lane < 8; ++lane) {
      const Eigen::Matrix3f m = random_covariance(random, lane % 4);
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) rows[j][k][lane] = alone[lane][j][k] = m(j, k);
    }
    const auto together = least_eigenvector<RowLanes>(rows);
    for (int lane = 0; lane < 8; ++lane) {
      const auto want = least_eigenvector<OneLane>(alone[lane]);
      for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(together[j][lane], want[j]);
    }
  }
}

TEST(Jacobi, DiagonalAndNothing) {
  float diagonal[3][3] = {{3, 0, 0}, {0, 1, 0}, {0, 0, 2}}, nothing[3][3] = {};
  EXPECT_EQ(least_eigenvector<OneLane>(diagonal), (std::array<float, 3>{0, 1, 0}));
  EXPECT_EQ(least_eigenvector<OneLane>(nothing), (std::array<float, 3>{1, 0, 0}));
}

// --- The passes. -------------------------------------------------------------------------------

/// A volume on a backend with its points, and their host copies.
struct Cloud {
  Cloud(Backend& b, const VolumeView& volume, const Scale& s)
      : backend(b), scale(s), bits(pack_volume(b, volume)), points(extract_points(b, bits, s)) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = to_host(backend, points.position[axis].view());
      area[axis] = to_host(backend, points.area[axis].view());
    }
  }

  std::array<std::vector<float>, 3> normals(NormalMode mode, int k = 10) {
    Parameters parameters;
    parameters.normals = mode;
    parameters.neighbours = k;
    estimate_normals(backend, bits, scale, parameters, points);
    return {to_host(backend, points.normal[0].view()), to_host(backend, points.normal[1].view()),
            to_host(backend, points.normal[2].view())};
  }

  Backend& backend;
  Scale scale;
  BitVolume bits;
  PointCloud points;
  std::array<std::vector<float>, 3> position, area;
};

Vec3 at(const std::array<std::vector<float>, 3>& vectors, std::size_t i) {
  return {vectors[0][i], vectors[1][i], vectors[2][i]};
}

/// A small tree, plates and specks: thick, thin, close to each other.
DenseVolume mixed_volume() {
  DenseVolume volume({34, 19, 21});
  volume.box({0, 0, 0}, {9, 9, 20}).box({10, 4, 4}, {33, 4, 4}).box({14, 8, 0}, {30, 9, 12});
  for (int i = 0; i < 12; ++i) volume.at(12 + i, 12 + i / 3, 8 + i) = 1;
  for (int z = 0; z < 21; ++z)
    for (int y = 0; y < 19; ++y)
      for (int x = 0; x < 34; ++x) {
        const double r = std::hypot(x - 22.3, std::hypot(y - 14.1, z - 3.2));
        if (r < 4.6) volume.at(x, y, z) = 1;
      }
  return volume;
}

std::vector<Scale> scales() { return {kCubes, {0.8606f, 0.8606f, 1.3501f}, {1.9f, 0.7f, 0.752f}}; }

class Normals : public BackendTest {};

/// What the gradient pass must give, and whether rounding could turn a decision.
struct ExpectedGradient {
  Vec3 normal;
  bool certain = true;
};

ExpectedGradient expected_gradient(const DenseVolume& object, const Vec3& position,
                                   const Vec3& area, const Scale& scale, double sigma) {
  ExpectedGradient expected;
  for (const double s : {sigma, sigma / 2}) {
    const Vec3 inward = reference::occupancy_gradient(object, position, scale, s);
    const double size = reference::length(inward);
    if (size < 0.02) expected.certain = false;
    const double against =
        reference::dot(inward, area) / std::max(size, 1e-9) / reference::length(area);
    const double limit = std::sqrt(kAgainstFaces);
    if (std::fabs(against - limit) < 1e-3) expected.certain = false;
    expected.normal = {-inward[0], -inward[1], -inward[2]};
    if (against < limit) return expected;
  }
  expected.normal = area;
  return expected;
}

TEST_P(Normals, GradientAsTheOracle) {
  const DenseVolume volume = mixed_volume(), object = reference::padded(volume);
  for (const Scale& scale : scales()) {
    Cloud cloud(backend(), volume.view(), scale);
    const auto normals = cloud.normals(NormalMode::gradient);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < cloud.points.count; i += 7) {
      const ExpectedGradient expected = expected_gradient(object, at(cloud.position, i),
                                                          at(cloud.area, i), scale, kGradientSigma);
      EXPECT_NEAR(reference::length(at(normals, i)), 1, 1e-6);
      if (!expected.certain) continue;
      ++compared;
      EXPECT_LT(reference::angle_degrees(at(normals, i), expected.normal), 0.02) << i;
    }
    EXPECT_GT(compared, cloud.points.count / 7 * 9 / 10);
  }
}

/// The samples of a cloud and the gradients that steer its covariance.
std::vector<reference::Sample> samples_of(Cloud& cloud) {
  Backend& backend = cloud.backend;
  std::array<Buffer<float>, 3> gradient;
  for (auto& g : gradient) g = Buffer<float>(backend, cloud.points.count);
  backend.normals_gradient(cloud.bits.view(), cloud.points.view(), cloud.scale, kSteeringSigma,
                           {gradient[0].view(), gradient[1].view(), gradient[2].view()});
  std::array<std::vector<float>, 3> values;
  for (int axis = 0; axis < 3; ++axis) values[axis] = to_host(backend, gradient[axis].view());
  const auto start = to_host(backend, cloud.points.voxel_start.view());
  const auto coords = to_host(backend, cloud.points.bricks.coords.view());
  std::vector<reference::Sample> samples(cloud.points.count);
  for (std::size_t v = 0; v + 1 < start.size(); ++v)
    for (std::size_t i = start[v]; i < start[v + 1]; ++i) {
      const BrickCoord& brick = coords[v / 512];
      const int cell = static_cast<int>(v % 512);
      samples[i] = {{8 * brick.x + cell % 8, 8 * brick.y + cell / 8 % 8, 8 * brick.z + cell / 64},
                    {cloud.position[0][i], cloud.position[1][i], cloud.position[2][i]},
                    {values[0][i], values[1][i], values[2][i]}};
    }
  return samples;
}

TEST_P(Normals, CovarianceAsTheOracle) {
  const DenseVolume volume = mixed_volume();
  for (const Scale& scale : scales())
    for (const int k : {3, 10, 64}) {
      Cloud cloud(backend(), volume.view(), scale);
      const auto normals = cloud.normals(NormalMode::covariance, k);
      const auto samples = samples_of(cloud);
      std::size_t compared = 0;
      for (std::size_t i = 0; i < samples.size(); i += 11) {
        const auto& g = samples[i].gradient;
        const reference::Plane expected = reference::plane_normal(
            reference::nearest(samples, i, scale, k), {g[0], g[1], g[2]}, at(cloud.area, i));
        EXPECT_NEAR(reference::length(at(normals, i)), 1, 1e-6);
        if (expected.gap < 1e-3) continue;
        ++compared;
        EXPECT_LT(reference::angle_degrees(at(normals, i), expected.normal), 0.05) << i;
      }
      EXPECT_GT(compared, samples.size() / 11 * 9 / 10);
    }
}

/// On a plain ball every sample near a point agrees with it: a k-d tree of the voxels' means finds
/// the same neighbours.
TEST_P(Normals, CovarianceAsAKdTree) {
  DenseVolume ball({26, 26, 26});
  for (int z = 0; z < 26; ++z)
    for (int y = 0; y < 26; ++y)
      for (int x = 0; x < 26; ++x)
        ball.at(x, y, z) = std::hypot(x - 12.6, std::hypot(y - 12.4, z - 12.7)) < 11.9;
  Cloud cloud(backend(), ball.view(), kCubes);
  const auto normals = cloud.normals(NormalMode::covariance);
  const auto samples = samples_of(cloud);

  using Means = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  Means means(samples.size(), 3);
  Eigen::Index voxels = 0;
  for (std::size_t first = 0, last = 0; first < samples.size(); first = last, ++voxels) {
    means.row(voxels).setZero();
    for (; last < samples.size() && samples[last].voxel == samples[first].voxel; ++last)
      for (int axis = 0; axis < 3; ++axis) means(voxels, axis) += samples[last].position[axis];
    means.row(voxels) /= static_cast<double>(last - first);
  }
  means.conservativeResize(voxels, 3);
  const nanoflann::KDTreeEigenMatrixAdaptor<Means> tree(3, std::cref(means));
  std::size_t compared = 0;
  for (std::size_t i = 0; i < samples.size(); i += 5) {
    const Vec3 p = at(cloud.position, i),
               g{samples[i].gradient[0], samples[i].gradient[1], samples[i].gradient[2]};
    std::array<Eigen::Index, 12> index;
    std::array<double, 12> distance;
    tree.index->knnSearch(p.data(), 12, index.data(), distance.data());
    if (distance[11] - distance[10] < 1e-4) continue;  // the eleventh is not the only one
    std::vector<reference::Neighbour> neighbours(11);
    for (int n = 0; n < 11; ++n)
      for (int axis = 0; axis < 3; ++axis)
        neighbours[n].offset[axis] = static_cast<float>(means(index[n], axis) - p[axis]);
    EXPECT_LT(reference::angle_degrees(
                  at(normals, i), reference::plane_normal(neighbours, g, at(cloud.area, i)).normal),
              0.05);
    ++compared;
  }
  EXPECT_GT(compared, 100u);
}

// --- Exact shapes. -----------------------------------------------------------------------------

/// A segmentation of an exact shape: a voxel is object when its centre is; lengths in voxels
/// (geometric mean), from the volume's corner.
struct Shape {
  std::string name;
  Geometry geometry;
  std::vector<std::uint8_t> voxels;
  std::function<Vec3(const Vec3&)> from_core;  ///< from the nearest point of axis or centre

  VolumeView view() const { return {voxels.data(), VoxelFormat::bytes, geometry}; }
};

Shape make_shape(std::string name, const Vec3& extent, double radius, const Vec3& spacing,
                 std::function<Vec3(const Vec3&)> from_core) {
  Shape shape{std::move(name), {}, {}, std::move(from_core)};
  shape.geometry.spacing = spacing;
  const Scale scale = make_scale(shape.geometry);
  auto& size = shape.geometry.size;
  for (int axis = 0; axis < 3; ++axis)
    size[axis] = static_cast<std::int64_t>(std::ceil(extent[axis] / scale[axis]));
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x)
        shape.voxels.push_back(
            reference::length(shape.from_core(
                {(x + 0.5) * scale[0], (y + 0.5) * scale[1], (z + 0.5) * scale[2]})) <= radius);
  return shape;
}

/// A capsule of a random direction.
Shape tube(double radius, const Vec3& spacing, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  Vec3 d{normal(random), normal(random), normal(random)}, extent, centre;
  const double size = reference::length(d), half = 25;
  for (int axis = 0; axis < 3; ++axis) {
    d[axis] /= size;
    extent[axis] = 2 * (half * std::fabs(d[axis]) + radius + 1.5);
    centre[axis] = extent[axis] / 2 + shift(random);
  }
  return make_shape("tube", extent, radius, spacing, [=](const Vec3& p) {
    const Vec3 q{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
    const double t = std::clamp(reference::dot(q, d), -half, half);
    return Vec3{q[0] - t * d[0], q[1] - t * d[1], q[2] - t * d[2]};
  });
}

/// Round the z axis; `shift` of its plane is in voxel lengths.
Shape torus(double radius, const Vec3& spacing, double shift) {
  const double large = 3 * radius + 4;
  const Vec3 centre{large + radius + 2.1, large + radius + 1.8, radius + 2 + shift};
  return make_shape("torus", {2 * centre[0], 2 * centre[1], 2 * centre[2]}, radius, spacing,
                    [=](const Vec3& p) {
                      Vec3 q{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
                      const double away = std::hypot(q[0], q[1]);
                      q[0] -= large * q[0] / away;
                      q[1] -= large * q[1] / away;
                      return q;
                    });
}

Shape sphere(double radius, const Vec3& spacing) {
  const Vec3 centre{radius + 2.2, radius + 1.9, radius + 2.45};
  return make_shape("sphere", {2 * centre[0], 2 * centre[1], 2 * centre[2]}, radius, spacing,
                    [=](const Vec3& p) {
                      return Vec3{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
                    });
}

/// Angles to the exact normals, in degrees, sorted.
std::vector<double> errors(Backend& backend, const std::vector<Shape>& shapes, NormalMode mode) {
  std::vector<double> all;
  for (const Shape& shape : shapes) {
    const Scale scale = make_scale(shape.geometry);
    Cloud cloud(backend, shape.view(), scale);
    const auto normals = cloud.normals(mode);
    for (std::size_t i = 0; i < cloud.points.count; ++i) {
      Vec3 p = at(cloud.position, i);
      for (int axis = 0; axis < 3; ++axis) p[axis] = (p[axis] - kPad) * scale[axis];
      all.push_back(reference::angle_degrees(at(normals, i), shape.from_core(p)));
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Largest mean and 95th percentile allowed, in degrees.
struct Limits {
  NormalMode mode;
  double mean, percentile_95;
};
constexpr Limits kLimits[] = {{NormalMode::covariance, 8, 16}, {NormalMode::gradient, 5, 10}};

void expect_errors(Backend& backend, const std::vector<Shape>& shapes) {
  for (const Limits& limits : kLimits) {
    const std::vector<double> angles = errors(backend, shapes, limits.mode);
    ASSERT_GT(angles.size(), 700u);
    double mean = 0;
    for (const double angle : angles) mean += angle / static_cast<double>(angles.size());
    EXPECT_LE(mean, limits.mean) << shapes[0].name;
    EXPECT_LE(angles[angles.size() * 95 / 100], limits.percentile_95) << shapes[0].name;
    EXPECT_LT(angles.back(), 90) << "a flipped normal, " << shapes[0].name;
  }
}

TEST_P(Normals, ErrorsOnExactShapes) {
  for (const auto& spacing : {kCubicSpacing, kCerebralSpacing})
    for (const double radius : {2.5, 5.0}) {
      std::vector<Shape> tubes;
      for (unsigned seed = 1; seed <= 6; ++seed) tubes.push_back(tube(radius, spacing, seed));
      expect_errors(backend(), tubes);
      std::vector<Shape> tori;
      for (const double shift : {0.0, 0.3, 0.6, 0.9}) tori.push_back(torus(radius, spacing, shift));
      expect_errors(backend(), tori);
    }
  for (const auto& spacing : {kCubicSpacing, kCerebralSpacing})
    expect_errors(backend(), {sphere(6.3, spacing)});
}

/// A one-voxel line beside a block, one voxel away: the block drowns the gradient of the line's
/// side that faces it, and yet no normal there points into the line.
TEST_P(Normals, ANearBlockDoesNotTurnALinesNormals) {
  DenseVolume volume({30, 24, 24});
  volume.box({0, 0, 0}, {29, 23, 11}).box({0, 12, 13}, {29, 12, 13});
  for (const NormalMode mode : {NormalMode::covariance, NormalMode::gradient}) {
    Cloud cloud(backend(), volume.view(), kCubes);
    const auto normals = cloud.normals(mode);
    std::size_t facing = 0;
    for (std::size_t i = 0; i < cloud.points.count; ++i) {
      const Vec3 p = at(cloud.position, i), area = at(cloud.area, i);
      if (p[2] < kPad + 12 || p[2] > kPad + 13 || area[0] != 0 || area[1] != 0) continue;
      EXPECT_GT(reference::dot(at(normals, i), area), -0.26 * reference::length(area)) << i;
      ++facing;
    }
    EXPECT_GT(facing, 200u);
  }
}

/// A plate of one voxel: both sheets within every neighbourhood, and yet exact.
TEST_P(Normals, TheSheetsOfAPlateStayApart) {
  DenseVolume plate({24, 22, 1});
  plate.box({0, 0, 0}, {23, 21, 0});
  for (const NormalMode mode : {NormalMode::covariance, NormalMode::gradient}) {
    Cloud cloud(backend(), plate.view(), kCubes);
    const auto normals = cloud.normals(mode);
    std::size_t inner = 0;
    for (std::size_t i = 0; i < cloud.points.count; ++i) {
      const Vec3 p = at(cloud.position, i), area = at(cloud.area, i);
      if (p[0] < kPad + 6 || p[0] > kPad + 18 || p[1] < kPad + 6 || p[1] > kPad + 16) continue;
      EXPECT_LT(reference::angle_degrees(at(normals, i), {0, 0, area[2]}), 0.5);
      ++inner;
    }
    EXPECT_GT(inner, 500u);
  }
}

// The backends that offer the stage.
INSTANTIATE_TEST_SUITE_P(Backends, Normals, ::testing::ValuesIn(backend_names()), test_name);

TEST(NormalThreads, SameBytesWithAnyNumberOfThreads) {
  const DenseVolume volume = test::random_volume({40, 31, 27}, 0.7, 5);
  const Scale scale{0.8606f, 0.8606f, 1.3501f};
  for (const NormalMode mode : {NormalMode::covariance, NormalMode::gradient}) {
    std::vector<std::array<std::vector<float>, 3>> results;
    for (const int threads : {1, 2, 4}) {
      const auto backend = make_tbb_backend(threads, nullptr);
      results.push_back(Cloud(*backend, volume.view(), scale).normals(mode));
    }
    EXPECT_GT(results[0][0].size(), 10000u);
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
  }
}

}  // namespace
}  // namespace vasamesh

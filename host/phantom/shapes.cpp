/// \file
/// Phantoms made of a few tubes, spheres and rings. All lengths grow with the vessel's radius.

#include <cmath>
#include <numbers>

#include "phantom/recipe.h"

namespace vasamesh::phantom {
namespace {

constexpr int kMargin = 4;  ///< background voxels round a shape
constexpr double kFine = 0.25;
const Vec3 kSpacing(0.8, 0.8, 0.8);
constexpr double kMurray = 0.79370052598409974;  ///< 2^(-1/3): radius after a fork into equals
constexpr double kPi = std::numbers::pi;

/// A place within a voxel that keeps symmetric shapes from meeting voxel centres.
Vec3 off_centre(const Ruler& ruler) { return Vec3(0.37, 0.21, 0.13).cwiseProduct(ruler.spacing); }

/// The voxels round `box` and a margin. A voxel centre lies at the frame's origin.
VoxelGrid lattice_around(const Eigen::AlignedBox3d& box, const Vec3& spacing, int margin) {
  VoxelGrid lattice;
  lattice.step = spacing;
  for (int a = 0; a < 3; ++a) {
    const int low = static_cast<int>(std::floor(box.min()[a] / spacing[a])) - margin;
    const int high = static_cast<int>(std::ceil(box.max()[a] / spacing[a])) + margin;
    lattice.start[a] = low * spacing[a];
    lattice.size[a] = high - low + 1;
  }
  return lattice;
}

Recipe shape(Shape solid, const Ruler& ruler, double least_radius, const Topology& topology) {
  Recipe recipe;
  recipe.lattice = lattice_around(solid.bounds(), ruler.spacing, kMargin);
  recipe.solid = std::move(solid);
  recipe.exact_step = kFine;
  recipe.least_radius = least_radius;
  recipe.topology = topology;
  return recipe;
}

RoundCone ball(const Vec3& centre, double radius) { return {centre, centre, radius, radius}; }

/// A tube of one radius along curve(t), 0 <= t <= 1, in `count` straight pieces.
template <class Curve>
Shape tube_along(const Curve& curve, int count, double radius) {
  std::vector<Vec3> points;
  for (int n = 0; n <= count; ++n) points.push_back(curve(static_cast<double>(n) / count));
  Shape solid;
  append_tube(solid.parts, points, std::vector<double>(points.size(), radius));
  return solid;
}

/// A one-voxel line along `way` (in voxels) out of the middle of a straight trunk.
Recipe line_on_trunk(const PhantomOptions& options, const Vec3& way) {
  const Ruler ruler(options, 4, kSpacing);
  const double half = 5 * ruler.radius;
  const Vec3 end =
      (std::ceil(ruler.radius / ruler.spacing.minCoeff()) + 20) * way.cwiseProduct(ruler.spacing);
  Shape solid;
  solid.parts.emplace_back(RoundCone({-half, 0, 0}, {half, 0, 0}, ruler.radius, ruler.radius));
  Recipe recipe = shape(std::move(solid), ruler, 0, {1, 0, 0});
  recipe.lines = {{Vec3::Zero(), end}};
  Eigen::AlignedBox3d bounds = recipe.solid.bounds();
  bounds.extend(end);
  recipe.lattice = lattice_around(bounds, ruler.spacing, kMargin);
  recipe.exact_step = 0;
  return recipe;
}

}  // namespace

Ruler::Ruler(const PhantomOptions& options, double radius_voxels, const Vec3& default_spacing)
    : spacing(default_spacing) {
  if (options.spacing) spacing = Vec3(options.spacing->data());
  voxel = std::cbrt(spacing.prod());
  radius = voxel * options.radius.value_or(radius_voxels);
}

Recipe sphere_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 10, kSpacing);
  Shape solid;
  solid.parts.emplace_back(ball(off_centre(ruler), ruler.radius));
  return shape(std::move(solid), ruler, ruler.radius, {1, 0, 0});
}

Recipe torus_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 4, kSpacing);
  Shape solid;
  const Vec3 axis = Vec3(0.2, 0.3, 1).normalized();
  solid.parts.emplace_back(Torus{off_centre(ruler), axis, 3.5 * ruler.radius, ruler.radius});
  return shape(std::move(solid), ruler, ruler.radius, {1, 1, 0});
}

Recipe helix_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 3, kSpacing);
  const double r = ruler.radius, turns = 2;
  const auto curve = [&](double t) {
    const double angle = 2 * kPi * turns * t;
    return Vec3(off_centre(ruler) +
                Vec3(4 * r * std::cos(angle), 4 * r * std::sin(angle), 4.5 * r * turns * t));
  };
  return shape(tube_along(curve, 192, r), ruler, r, {1, 0, 0});
}

Recipe y_branch_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 4, kSpacing);
  const double r = ruler.radius, child = kMurray * r;
  // Murray's angle for equal children: cos = 2^(-1/3) of each from the parent's line.
  const double along = kMurray, across = std::sqrt(1 - along * along);
  const Vec3 fork = off_centre(ruler), out = Vec3(0, 1, 0.3).normalized();
  Shape solid;
  solid.parts.emplace_back(RoundCone(fork - Vec3(6 * r, 0, 0), fork, r, r));
  for (const double side : {-1.0, 1.0}) {
    const Vec3 way = along * Vec3(1, 0, 0) + side * across * out;
    solid.parts.emplace_back(RoundCone(fork, fork + 6 * r * way, child, child));
  }
  return shape(std::move(solid), ruler, child, {1, 0, 0});
}

Recipe aneurysm_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 3.5, kSpacing);
  const double r = ruler.radius;
  const auto curve = [&](double t) {
    const double angle = kPi * (0.15 + 0.7 * t);
    return Vec3(off_centre(ruler) + 8 * r * Vec3(std::cos(angle), std::sin(angle), 0.2 * t));
  };
  Shape solid = tube_along(curve, 64, r);
  const Vec3 middle = curve(0.5);
  solid.parts.emplace_back(ball(middle + Vec3(0.2 * r, 2.3 * r, 0.3 * r), 2.1 * r));
  return shape(std::move(solid), ruler, r, {1, 0, 0});
}

Recipe two_tubes_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 4.4, kSpacing);
  const double r = ruler.radius;
  // Both axes on voxel centres, one layer of background between the rows inside.
  const double rows = std::ceil(r / ruler.spacing[1]) - 1;
  const Vec3 half(5 * r, 0, 0), apart(0, (2 * rows + 2) * ruler.spacing[1], 0);
  Shape solid;
  solid.parts.emplace_back(RoundCone(-half, half, r, r));
  solid.parts.emplace_back(RoundCone(apart - half, apart + half, r, r));
  return shape(std::move(solid), ruler, r, {2, 0, 0});
}

Recipe cut_tube_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 4.5, kSpacing);
  const double r = ruler.radius;
  const Vec3 way = 12 * r * Vec3(1, 0.25, 0.15);
  Shape solid;
  solid.parts.emplace_back(RoundCone(off_centre(ruler) - way, off_centre(ruler) + way, r, r));
  Recipe recipe = shape(std::move(solid), ruler, r, {1, 0, 0});
  const Vec3 half(5 * r, 3 * r, 3 * r);
  recipe.lattice = lattice_around({Vec3(-half), half}, ruler.spacing, 0);
  return recipe;
}

Recipe hollow_shell_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 12, kSpacing);
  Shape solid;
  solid.parts.emplace_back(ball(off_centre(ruler), ruler.radius));
  solid.holes.emplace_back(ball(off_centre(ruler), 0.55 * ruler.radius));
  return shape(std::move(solid), ruler, 0.55 * ruler.radius, {1, 0, 1});
}

Recipe anisotropic_arch_recipe(const PhantomOptions& options) {
  const Ruler ruler(options, 3.5, {0.6, 0.6, 1.2});
  const double r = ruler.radius, leg = 6 * r, bow = 4.5 * r, arc = kPi * bow;
  const auto curve = [&](double t) {
    const double way = (2 * leg + arc) * t - leg;  // 0 .. arc is the bow
    const double angle = std::clamp(way, 0.0, arc) / bow;
    const double down = std::max({0.0, -way, way - arc});
    const double across = -bow * std::cos(angle);
    return Vec3(off_centre(ruler) +
                Vec3(0.94 * across, 0.34 * across, bow * std::sin(angle) - down));
  };
  return shape(tube_along(curve, 192, r), ruler, r, {1, 0, 0});
}

Recipe line_axis_recipe(const PhantomOptions& options) { return line_on_trunk(options, {0, 1, 0}); }
Recipe line_face_diagonal_recipe(const PhantomOptions& options) {
  return line_on_trunk(options, {0, 1, 1});
}
Recipe line_space_diagonal_recipe(const PhantomOptions& options) {
  return line_on_trunk(options, {1, 1, 1});
}

}  // namespace vasamesh::phantom

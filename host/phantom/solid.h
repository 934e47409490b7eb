#pragma once

/// \file
/// Shapes as signed distance functions: swept balls and tori, joined and subtracted.

#include <Eigen/Geometry>
#include <variant>
#include <vector>

namespace vasamesh::phantom {

using Vec3 = Eigen::Vector3d;

/// All balls between ball (a, radius_a) and ball (b, radius_b), centre and radius changing
/// linearly: a sphere (a = b), a capsule or a rounded cone.
class RoundCone {
 public:
  RoundCone(const Vec3& a, const Vec3& b, double radius_a, double radius_b);
  double distance(const Vec3& p) const;
  Eigen::AlignedBox3d bounds() const;

 private:
  Vec3 a_, axis_;
  double length_, radius_a_, radius_b_;
  double slope_;  ///< radius lost a unit of length
  double lean_;   ///< tangent of the angle between surface and axis
};

/// A ring of `ring` radius about the unit vector `axis`, thickened by `tube`.
struct Torus {
  Vec3 centre, axis;
  double ring, tube;

  double distance(const Vec3& p) const;
  Eigen::AlignedBox3d bounds() const;
};

using Part = std::variant<RoundCone, Torus>;

/// The union of `parts` without the union of `holes`.
struct Shape {
  std::vector<Part> parts, holes;

  /// Below zero inside. Changes by no more than the way gone, and is the Euclidean distance outside
  /// the parts; infinite for no parts.
  double distance(const Vec3& p) const;

  /// Only what lies within `reach` of a point: at a place that is `away` from `centre` the distance
  /// is right where it is at most `reach - away`, and elsewhere too large.
  Shape near(const Vec3& centre, double reach) const;

  /// A box round the parts; empty for none.
  Eigen::AlignedBox3d bounds() const;
};

/// Appends a swept ball along a polyline; `radius` has an entry a point.
void append_tube(std::vector<Part>& parts, const std::vector<Vec3>& points,
                 const std::vector<double>& radius);

}  // namespace vasamesh::phantom

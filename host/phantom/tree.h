#pragma once

/// \file
/// Random vessel trees: scattered targets are joined one after the other to the tree, each where it
/// costs least wire and way from the root (Cuntz, Forstner, Borst and Haeusser, "One rule to grow
/// them all", 2010). Radii follow Murray's law, r0^3 = r1^3 + r2^3.

#include <cstdint>
#include <vector>

#include "phantom/solid.h"

namespace vasamesh::phantom {

/// A vessel with a radius at each of its points; a swept ball.
struct Vessel {
  std::vector<Vec3> points;
  std::vector<double> radius;
};

/// Targets scattered evenly in an ellipsoid without its inner part.
struct TargetRegion {
  Vec3 centre, half_axes;
  double hollow;  ///< inner ellipsoid left out, as a fraction of the half axes, below 1
  int count;
};

struct TreePlan {
  std::uint64_t seed = 1;
  std::vector<Vessel> trunks;  ///< given vessels, from their roots on; a radius is a least one
  std::vector<TargetRegion> regions;
  Eigen::AlignedBox3d room;    ///< trunks branch only in it; the regions should lie in it
  double step = 1.5;           ///< distance of a spline's knots, mm
  double balance = 0.15;       ///< weight of the way from the trunk against new wire
  double turning = 0.4;        ///< weight of turning away from the vessel's direction
  double bare_radius = 1e9;    ///< trunks thicker than this branch only at their ends, mm
  double tip_radius = 0.45;    ///< before the taper, mm
  double end_radius = 0.3;     ///< of a tip after the taper, mm
  double bending = 3;          ///< amplitude of the smooth deformation of space, mm
  double bending_length = 40;  ///< its wavelength, mm
};

/// No point is moved farther along an axis than this times TreePlan::bending.
inline constexpr double kLargestBend = 2.2;

/// The vessels of a grown tree, trunks first, as smooth curves of short pieces. A vessel starts at
/// a point of an earlier one. The same for the same plan.
std::vector<Vessel> grow_tree(const TreePlan& plan);

}  // namespace vasamesh::phantom

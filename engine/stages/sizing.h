#pragma once

/// \file
/// How long edges are to be, from the radius of curvature (eq. 5 of the paper):
/// h(p) = min over q of (min(clamp(rho r(q), edge_min, edge_max), 1.25 r(q)) + gradation |p - q|).
///
/// Sizes lie in the bricks of the indicator field at voxel resolution: 4 x 4 x 4 cells a brick.
/// Radii are taken once for each such cell that the base surface passes.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/field.h"
#include "types/sizes.h"
#include "types/vec3.h"
#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// How far a base vertex may be from the zero set, in voxel lengths; Newton steps onto it.
inline constexpr float kSampleReach = 0.5f;
inline constexpr int kSampleSteps = 6;

inline constexpr float kLargestRadius = 1e6f;

/// The surface at one place of each cell that it passes, in ascending order of cells.
struct SurfaceSamples {
  std::vector<std::uint32_t> cell;  ///< 64 * brick + place
  std::vector<Vec3> position;       ///< on the function's zero set, or else a base vertex
  std::vector<Vec3> normal;         ///< outward; zero where the zero set was not found
  std::vector<float> radius;        ///< of curvature; 0 where the zero set was not found; at most
                                    ///< that of a small shell that passes the cell

  std::size_t count() const { return cell.size(); }
};

struct SizeField {
  Buffer<float> sizes;  ///< 64 a brick of the field
  SurfaceSamples samples;
  double predicted_triangles = 0;

  SizeView view(const IndicatorField& field) const { return {field.view(), sizes.view(), largest}; }
  float largest = 1;  ///< where nothing asks for less
};

/// What the sizes are made by, in voxel lengths.
struct SizeRule {
  float rho = 0.6f;       ///< edge length over radius of curvature
  float chord_error = 0;  ///< above 0: sqrt(8 chord_error r) in place of rho r
  float edge_min = 1.0f;
  float edge_max = 1.6f;
  float gradation = 0.25f;  ///< growth of the edge length a length
};

/// The least of the radii |p - q| / |n(p) - n(q)| (d / (2 sin(theta / 2)) of eq. 5) in six
/// directions about one voxel length from p, which is on the surface with that outward normal;
/// where it comes out larger, two, four and at last seven lengths from p, so that the steps of the
/// voxels along a wide vessel do not count as its curvature. Where a direction finds no surface, at
/// half the distance; 0 where that fails too.
/// \param ample  radii from here on need not be told apart: the first that is found will do.
float radius_of_curvature(const FieldView& field, const Vec3& p, const Vec3& normal, float ample);

/// The radius from which on the rule's edges are as long as any, and half as much again, since
/// radii are smoothed.
float ample_radius(const SizeRule& rule);

/// \param surface  the base surface, in voxel lengths: where the radii are taken.
/// \param ample  of all rules that will be applied (radius_of_curvature()).
SizeField make_sizes(Backend& backend, const IndicatorField& field, const TriangleMesh& surface,
                     const SizeRule& rule, float ample = kLargestRadius);

/// The same by another rule, from the radii that `sizes` has; shorter in the places, by the least
/// of their factors, of which none counts below 0.4.
void apply_rule(Backend& backend, const IndicatorField& field, const TriangleMesh& surface,
                const SizeRule& rule, std::span<const CarefulPlace> places, SizeField& sizes);

/// Lowers each value to what its 26 neighbours allow, value(p) <= value(q) + growth |p - q|, until
/// all obey: to the least over the paths from another value, summed step by step from there.
/// \param values  64 a brick of the field.
void grow_limited(Backend& backend, const IndicatorField& field, float growth,
                  Buffer<float>& values);

}  // namespace vasamesh

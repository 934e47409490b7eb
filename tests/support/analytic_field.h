#pragma once

/// \file
/// Indicator functions of known surfaces, as the mesh stages get them: the spline over a dense
/// cube of nodes, in host memory; and one size everywhere.

#include <functional>
#include <vector>

#include "types/indicator_field.h"
#include "types/sizes.h"
#include "types/vec3.h"

namespace vasamesh::test {

class AnalyticField {
 public:
  /// `value` is positive inside; the cube goes from the origin to `side` (a multiple of 4) along
  /// each axis, in voxel lengths.
  AnalyticField(int side, const std::function<float(const Vec3&)>& value);

  FieldView view();
  SizeView sizes(float size);

 private:
  int bricks_;
  std::vector<std::int32_t> brick_at_;
  std::vector<float> coefficients_;
};

/// The distance to the surface, positive inside.
AnalyticField sphere_field(int side, const Vec3& centre, float radius);
AnalyticField torus_field(int side, const Vec3& centre, float large, float small);
/// Inside is below `height`.
AnalyticField plane_field(int side, float height);

}  // namespace vasamesh::test

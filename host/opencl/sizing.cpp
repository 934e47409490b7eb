/// Samples of the surface: kernels/sizing.cl.

#include "stages/sizing.h"

#include "opencl/opencl_backend.h"

namespace vasamesh {

void OpenClBackend::sizing_measure(const FieldView& field, View<Vec3> positions, View<Vec3> normals,
                                   View<float> radii) {
  const Scale& inverse = field.inverse_step;
  launch("sizing_measure", groups_of(positions.size), shape_.fold_items, cl_ulong{positions.size},
         cl_int4{{field.grid[0], field.grid[1], field.grid[2], 0}},
         cl_float4{{inverse[0], inverse[1], inverse[2], 0}}, field.brick_at, field.coefficients,
         positions, normals, radii);
}

}  // namespace vasamesh

/// Samples of the surface: kernels/sizing.cl.

#include "stages/sizing.h"

#include "opencl/opencl_backend.h"

namespace vasamesh {

void OpenClBackend::sizing_measure(const FieldView& field, float ample, View<Vec3> positions,
                                   View<Vec3> normals, View<float> radii) {
  launch("sizing_measure", groups_of(positions.size), shape_.fold_items, cl_ulong{positions.size},
         ample, field, positions, normals, radii);
}

}  // namespace vasamesh

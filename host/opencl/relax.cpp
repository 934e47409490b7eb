/// Smoothing and moves towards equal edges: kernels/relax.cl.

#include <cstddef>

#include "opencl/opencl_backend.h"

namespace vasamesh {

static_assert(sizeof(SurfacePoint) == 36 && offsetof(SurfacePoint, normal) == 12 &&
                  offsetof(SurfacePoint, size) == 24 && offsetof(SurfacePoint, drift) == 28,
              "RELAX_POINT of kernels/relax.cl");
static_assert(sizeof(PlaceCell) == 16 && sizeof(CarefulPlace) == 20, "RelaxPlaceCell");

void OpenClBackend::relax_smooth(const FieldView& field, const SizeView& sizes,
                                 const PlaceView& places, const FanView& fans, int passes,
                                 View<SurfacePoint> points) {
  launch("relax_smooth", fans.parts(), shape_.brick_items, field, sizes, places, fans.part_level,
         fans.level_first, fans.vertex, fans.ring_first, fans.ring, cl_int{passes}, points);
}

void OpenClBackend::relax_equalise(const FieldView& field, const SizeView& sizes,
                                   const PlaceView& places, const FanView& fans, int passes,
                                   bool onto, View<SurfacePoint> points) {
  launch("relax_equalise", fans.parts(), shape_.brick_items, field, sizes, places, fans.part_level,
         fans.level_first, fans.vertex, fans.ring_first, fans.ring, cl_int{passes}, cl_int{onto},
         points);
}

void OpenClBackend::relax_gaps(const FieldView& field, const FanView& fans,
                               View<const SurfacePoint> points, View<float> gaps) {
  launch("relax_gaps", groups_of(gaps.size), shape_.fold_items, cl_ulong{gaps.size}, field,
         fans.vertex, fans.ring_first, fans.ring, points, gaps);
}

}  // namespace vasamesh

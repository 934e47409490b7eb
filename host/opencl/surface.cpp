/// The base surface: kernels/surface.cl.

#include <utility>

#include "opencl/opencl_backend.h"
#include "types/tetrahedra.h"

namespace vasamesh {

static_assert(sizeof(CubeCase) == 37, "SURFACE_CASE of kernels/surface.cl");

/// The table of cases on the device, put there when it is first asked for.
View<const CubeCase> OpenClBackend::cube_cases() {
  if (cube_cases_.size() == 0) {
    Buffer<CubeCase> cases(*this, kCubeCases.size());
    upload<CubeCase>(cases.view(), kCubeCases);
    cube_cases_ = std::move(cases);
  }
  return cube_cases_.view();
}

void OpenClBackend::surface_count(const BrickView& bricks, View<const std::uint8_t> state,
                                  View<std::uint8_t> crossed, View<std::uint16_t> node_start,
                                  View<std::uint32_t> vertices, View<std::uint32_t> triangles) {
  launch("surface_count", bricks.count, shape_.brick_items, bricks.neighbours, state, cube_cases(),
         crossed, node_start, vertices, triangles);
}

void OpenClBackend::surface_emit(const BrickView& bricks, View<const std::uint8_t> state,
                                 View<const float> values, float margin,
                                 View<const std::uint8_t> crossed,
                                 View<const std::uint16_t> node_start,
                                 View<const std::uint32_t> vertex_start,
                                 View<const std::uint32_t> triangle_start, View<float> vertices,
                                 View<std::uint32_t> triangles) {
  launch("surface_emit", bricks.count, shape_.brick_items, margin, bricks.coords, bricks.neighbours,
         state, values, cube_cases(), crossed, node_start, vertex_start, triangle_start, vertices,
         triangles);
}

}  // namespace vasamesh

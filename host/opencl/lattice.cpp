/// The cell lattice: kernels/lattice.cl and kernels/far.cl.

#include <span>

#include "opencl/opencl_backend.h"
#include "stages/far_cubes.h"
#include "stages/far_offsets.h"

namespace vasamesh {

namespace {

cl_int4 size_of(const BitView& bits) {
  return {{bits.size[0], bits.size[1], bits.size[2], bits.words_per_row}};
}

cl_int4 radius_of(const std::array<int, 3>& radius) { return {{radius[0], radius[1], radius[2]}}; }

template <class T>
Buffer<T> uploaded(Backend& backend, std::span<const T> values) {
  Buffer<T> buffer(backend, values.size());
  backend.upload(buffer.view(), values);
  return buffer;
}

}  // namespace

void OpenClBackend::lattice_mark(const BitView& object, const BrickView& bricks,
                                 const std::array<int, 3>& radius, View<std::uint8_t> used) {
  launch("lattice_mark", bricks.count, shape_.brick_items, size_of(object), radius_of(radius),
         object.words, bricks.coords, used);
}

void OpenClBackend::lattice_label(const BitView& object, int connectivity, const BrickView& bricks,
                                  const std::array<int, 3>& radius, View<std::uint8_t> state) {
  launch("lattice_label", bricks.count, shape_.brick_items, size_of(object), connectivity,
         radius_of(radius), object.words, bricks.coords, state);
}

void OpenClBackend::lattice_sample(const BrickView& bricks, View<const std::int32_t> in_regular,
                                   View<const float> regular, View<const std::int32_t> in_refined,
                                   View<const float> refined, View<float> values) {
  launch("lattice_sample", bricks.count, shape_.brick_items, bricks.coords, in_regular, regular,
         in_refined, refined, values);
}

std::uint32_t OpenClBackend::lattice_mark_far(const BrickView& bricks,
                                              View<const std::uint8_t> active, const Scale& scale,
                                              float limit, View<const std::uint8_t> state,
                                              View<const float> values, View<std::uint8_t> marks) {
  const FarOffsets offsets = make_far_offsets(scale, limit);
  const FarCubes& far = far_cubes();
  const auto beside = uploaded<FarOffset>(*this, offsets.beside),
             search = uploaded<FarOffset>(*this, offsets.search);
  const auto parts = uploaded<FarPart>(*this, make_far_parts(scale));
  const auto cubes = uploaded<FarCube>(*this, far.cubes);
  const auto cube_parts = uploaded<std::uint16_t>(*this, far.parts),
             cube_sides = uploaded<std::uint16_t>(*this, far.sides);
  const cl_float4 half_scale{{0.5f * scale[0], 0.5f * scale[1], 0.5f * scale[2], 0}};
  cl_float8 edge_length{};
  for (std::size_t d = 0; d < 7; ++d) edge_length.s[d] = offsets.edge_length[d];
  launch("lattice_mark_far", bricks.count, shape_.brick_items, half_scale, limit, edge_length,
         static_cast<cl_int>(offsets.beside.size()), static_cast<cl_int>(offsets.search.size()),
         beside.view(), search.view(), parts.view(), cubes.view(), cube_parts.view(),
         cube_sides.view(), bricks.neighbours, active, state, values, marks,
         counts_of(bricks.count));
  return sum_of_counts();
}

}  // namespace vasamesh

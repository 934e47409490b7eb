/// Packing, the top-hat, and the samples: kernels/thin.cl and kernels/points.cl.

#include "stages/points.h"

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

/// The padded volume's size, and the words of a row.
cl_int4 size_of(const BitView& bits) {
  return {{bits.size[0], bits.size[1], bits.size[2], bits.words_per_row}};
}

}  // namespace

void OpenClBackend::volume_pack(const VolumeView& volume, const std::array<int, 3>& size,
                                int words_per_row, View<std::uint64_t> words) {
  const bool bytes = volume.format == VoxelFormat::bytes;
  const auto& given = volume.geometry.size;
  const auto row = static_cast<std::size_t>(bytes ? given[0] : (given[0] + 7) / 8);
  // The caller's voxels are lent to the device, which does not write them.
  const View<const unsigned char> voxels{
      const_cast<void*>(volume.data), 0,
      row * static_cast<std::size_t>(given[1]) * static_cast<std::size_t>(given[2])};
  const cl_ulong count = BitView{size, words_per_row, words}.word_count();
  launch("volume_pack", groups_of(count), shape_.fold_items, voxels,
         cl_long4{{given[0], given[1], given[2], 0}}, cl_int{bytes},
         cl_int4{{size[0], size[1], size[2], words_per_row}}, count, words);
}

void OpenClBackend::points_thin_mask(const BitView& object, View<std::uint64_t> thin,
                                     View<std::uint64_t> refine) {
  const cl_int4 size = size_of(object);
  const cl_ulong rows = static_cast<cl_ulong>(object.size[1]) * object.size[2];
  Buffer<std::uint8_t> is_thin(*this, rows);
  // The eroded object lies in `refine` for the time being.
  launch("points_thin_erode", groups_of(rows), shape_.fold_items, size, rows, object.words, refine);
  launch("points_thin_subtract", groups_of(rows), shape_.fold_items, size, rows, object.words,
         View<const std::uint64_t>(refine), thin, is_thin.view());
  launch("points_thin_dilate", groups_of(rows), shape_.fold_items, size, rows,
         View<const std::uint64_t>(thin), View<const std::uint8_t>(is_thin.view()), refine);
}

void OpenClBackend::points_mark_bricks(const BitView& object, View<std::uint8_t> octants) {
  const cl_ulong count = static_cast<cl_ulong>(object.words_per_row) *
                         (object.size[1] / kBrickSide) * (object.size[2] / kBrickSide);
  launch("points_mark_bricks", groups_of(count), shape_.fold_items, size_of(object), count,
         object.words, octants);
}

void OpenClBackend::points_count(const BitView& object, const BitView& refine,
                                 const BrickView& bricks, View<std::uint32_t> counts,
                                 View<std::uint32_t> refined) {
  launch("points_count", bricks.count, shape_.brick_items, size_of(object), object.words,
         refine.words, bricks.coords, counts, refined);
}

void OpenClBackend::points_emit(const BitView& object, const BitView& thin, const BitView& refine,
                                const BrickView& bricks, View<const std::uint32_t> voxel_start,
                                const Scale& scale, const PointOutput& points) {
  const cl_float4 face_area{{scale[1] * scale[2], scale[0] * scale[2], scale[0] * scale[1], 0}};
  launch("points_emit", bricks.count, shape_.brick_items, size_of(object), face_area, object.words,
         thin.words, refine.words, bricks.coords, voxel_start, points.position, points.area,
         points.thickness);
}

}  // namespace vasamesh

/// Normal vectors: kernels/normals.cl.

#include "stages/normals.h"

#include <vector>

#include "opencl/opencl_backend.h"
#include "stages/gradient_table.h"

namespace vasamesh {

namespace {

cl_int4 reach_of(const GradientTable& table) {
  return {{table.reach[0], table.reach[1], table.reach[2], 0}};
}

/// The voxels along y and z, and the patterns along x, of one table after the other.
std::vector<GradientSum> joined(const GradientTable& wide, const GradientTable& narrow) {
  std::vector<GradientSum> sums;
  for (const GradientTable* table : {&wide, &narrow})
    for (const auto* part : {&table->voxel[0], &table->voxel[1], &table->row})
      sums.insert(sums.end(), part->begin(), part->end());
  return sums;
}

}  // namespace

void OpenClBackend::normals_gradient(const BitView& object, const PointView& points,
                                     const Scale& scale, float sigma,
                                     std::array<View<float>, 3> normals) {
  const GradientTable wide = make_gradient_table(scale, sigma);
  const GradientTable narrow = make_gradient_table(scale, 0.5f * sigma);
  const std::vector<GradientSum> sums = joined(wide, narrow);
  Buffer<GradientSum> tables(*this, sums.size());
  upload<GradientSum>(tables.view(), sums);
  const cl_int4 size{{object.size[0], object.size[1], object.size[2], object.words_per_row}};
  launch("normals_gradient", groups_of(points.count), shape_.fold_items, cl_ulong{points.count},
         size, reach_of(wide), reach_of(narrow), object.words,
         View<const GradientSum>(tables.view()), points.position, points.area, normals);
}

void OpenClBackend::normals_covariance(const PointView& points, const BrickView& bricks,
                                       View<const std::uint32_t> voxel_start, const Scale& scale,
                                       int k, std::array<View<const float>, 3> gradients,
                                       std::array<View<float>, 3> normals) {
  Buffer<float> samples(*this, 8 * points.count);
  launch("normals_gather", groups_of(points.count), shape_.fold_items, cl_ulong{points.count},
         points.position, gradients, samples.view());
  launch("normals_covariance", bricks.count, shape_.brick_items, cl_int{k + 1},
         cl_float4{{scale[0], scale[1], scale[2], 0}}, View<const float>(samples.view()),
         bricks.coords, bricks.neighbours, voxel_start, points.area, normals);
}

}  // namespace vasamesh

#pragma once

/// \file
/// The backend contract: the data-parallel passes of the pipeline over flat arrays. The stages
/// (engine/stages) are written once above it; a backend (host/tbb, host/opencl) implements it.
///
/// One arithmetic for all backends: float32 and integers; +, -, *, /, square root, and fma only
/// where it is written; no contraction; sums in an order that depends on sizes alone; ties broken
/// by index. Two backends give the same bytes. A pass gets views alone, keeps nothing, and writes
/// only the views that are not const. All views of one call belong to the backend called.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "backend/buffer.h"
#include "types/bricks.h"
#include "types/octree.h"
#include "types/point_cloud.h"
#include "types/volume.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// The stages that a backend may offer.
enum class Stage { points, normals, octree, poisson, lattice, surface, verify };

class Backend : public Memory {
 public:
  virtual std::string name() const = 0;    ///< "tbb", "opencl"
  virtual std::string device() const = 0;  ///< what it runs on, for people
  virtual bool offers(Stage stage) const = 0;
  virtual std::size_t bytes_held() const = 0;
  virtual std::size_t bytes_peak() const = 0;
  virtual void set_byte_limit(std::size_t bytes) = 0;  ///< 0: none; allocate() throws above it

  // --- Copies. `bytes` from byte `offset` of an allocation. ---------------------------------

  virtual void write(void* handle, std::size_t offset, const void* from, std::size_t bytes) = 0;
  virtual void read(const void* handle, std::size_t offset, void* to, std::size_t bytes) = 0;

  template <class T>
  void upload(View<T> to, std::span<const T> from) {
    if (!from.empty()) write(to.handle, to.offset * sizeof(T), from.data(), from.size_bytes());
  }
  template <class T>
  void download(View<const T> from, std::span<T> to) {
    if (!to.empty()) read(from.handle, from.offset * sizeof(T), to.data(), to.size_bytes());
  }

  // --- Host work of stages that have no kernels. ----------------------------------------------

  /// task(i) for i in 0 .. tasks - 1 on the backend's workers, in any order and at the same time;
  /// returns when all are done, with the exception of one of them if any threw. Tasks write
  /// places of their own, so that no result depends on the order; make them coarse (tens of
  /// microseconds), their number by sizes alone.
  virtual void run(std::size_t tasks, const std::function<void(std::size_t)>& task) = 0;

  // --- Primitives. ---------------------------------------------------------------------------

  virtual void fill(View<float> values, float value) = 0;
  virtual void fill(View<std::uint8_t> values, std::uint8_t value) = 0;
  virtual void fill(View<std::uint32_t> values, std::uint32_t value) = 0;

  /// sums[i] = values[0] + ... + values[i - 1]; sums has one entry more than values. May be the
  /// same memory. \return the total. \throws Error refused when it passes 32 bits.
  virtual std::uint32_t exclusive_scan(View<const std::uint32_t> values,
                                       View<std::uint32_t> sums) = 0;

  /// Pairwise sum: values padded by zeros to a power of two n, then v[i] + v[i + n/2] for the
  /// lower half, and so on down to one. 0 for no values.
  virtual float reduce_sum(View<const float> values) = 0;

  // --- Points (engine/stages/points.h). --------------------------------------------------------

  /// Packs the caller's bytes or bits into the padded volume; every word is written.
  virtual void volume_pack(const VolumeView& volume, const std::array<int, 3>& size,
                           int words_per_row, View<std::uint64_t> words) = 0;

  /// thin = object minus its opening by a 3 x 3 x 3 cube; refine = thin dilated by the cube.
  virtual void points_thin_mask(const BitView& object, View<std::uint64_t> thin,
                                View<std::uint64_t> refine) = 0;

  /// Which octants of each of the volume's bricks (raster order, size / 8 along each axis) hold
  /// outer boundary voxels: background with an object 6-neighbour. Bit dx + 2 dy + 4 dz.
  virtual void points_mark_bricks(const BitView& object, View<std::uint8_t> octants) = 0;

  /// How many points each voxel of each brick gives (counts: 512 a brick).
  virtual void points_count(const BitView& object, const BitView& refine, const BrickView& bricks,
                            View<std::uint32_t> counts) = 0;

  /// Writes position, area and thickness of the points; voxel_start is the scan of the counts.
  virtual void points_emit(const BitView& object, const BitView& thin, const BitView& refine,
                           const BrickView& bricks, View<const std::uint32_t> voxel_start,
                           const Scale& scale, const PointOutput& points) = 0;

  // --- Normals (engine/stages/normals.h). ------------------------------------------------------

  /// Outward unit gradient of the occupancy smoothed by a Gaussian of `sigma` voxel lengths; where
  /// it vanishes, the area vector's direction.
  virtual void normals_gradient(const BitView& object, const PointView& points, const Scale& scale,
                                float sigma, std::array<View<float>, 3> normals) = 0;

  /// Outward unit eigenvector of the smallest eigenvalue of the covariance of the k nearest
  /// neighbours whose `gradient` agrees with the point's own, oriented by that gradient.
  virtual void normals_covariance(const PointView& points, const BrickView& bricks,
                                  View<const std::uint32_t> voxel_start, const Scale& scale, int k,
                                  std::array<View<const float>, 3> gradients,
                                  std::array<View<float>, 3> normals) = 0;

  // --- Indicator function (engine/stages/poisson.h). -------------------------------------------
  // Arrays of a level have 512 values a brick. A neighbour that is not there counts as zero.

  /// q = A p on unknown cells and 0 elsewhere, A the 7-point operator:
  /// (A p)(c) = sum over the axes i of weights[i] * (2 p(c) - p(c - e_i) - p(c + e_i)), summed as
  /// (wx * tx + wy * ty) + wz * tz with t = (2 p - p(c - e)) - p(c + e).
  /// partial[brick] = sum of p q over the brick: lane x adds its 64 cells in order of y, then z;
  /// lanes are then added pairwise, ((0+4)+(2+6)) + ((1+5)+(3+7)).
  virtual void poisson_apply(const LevelView& level, View<const std::uint8_t> unknown,
                             View<const float> p, View<float> q, View<float> partial) = 0;

  /// r = b - A x on unknown cells and 0 elsewhere; partial[brick] = sum of r r, as above.
  virtual void poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                                View<const float> b, View<const float> x, View<float> r,
                                View<float> partial) = 0;

  /// x += alpha p, r -= alpha q; partial[brick] = sum of r r, as above.
  virtual void poisson_update_solution(const LevelView& level, float alpha, View<const float> p,
                                       View<const float> q, View<float> x, View<float> r,
                                       View<float> partial) = 0;

  /// p = r + beta p.
  virtual void poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                        View<float> p) = 0;
};

}  // namespace vasamesh

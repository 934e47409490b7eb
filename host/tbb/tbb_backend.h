#pragma once

/// \file
/// The oneTBB backend's class; its passes are in a file a stage beside this one.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <memory>

#include "backend/backend.h"

namespace vasamesh {

class TbbBackend final : public Backend {
 public:
  TbbBackend(int threads, void* task_arena);

  std::string name() const override { return "tbb"; }
  std::string device() const override;
  bool offers(Stage) const override { return true; }
  std::size_t bytes_held() const override { return held_; }
  std::size_t bytes_peak() const override { return peak_; }
  void set_byte_limit(std::size_t bytes) override { limit_ = bytes; }

  void* allocate(std::size_t bytes) override;
  void release(void* handle, std::size_t bytes) noexcept override;
  void write(void* handle, std::size_t offset, const void* from, std::size_t bytes) override;
  void read(const void* handle, std::size_t offset, void* to, std::size_t bytes) override;

  void run(std::size_t tasks, const std::function<void(std::size_t)>& task) override;

  void fill(View<float> values, float value) override;
  void fill(View<std::uint8_t> values, std::uint8_t value) override;
  void fill(View<std::uint32_t> values, std::uint32_t value) override;
  std::uint32_t exclusive_scan(View<const std::uint32_t> values,
                               View<std::uint32_t> sums) override;
  float reduce_sum(View<const float> values) override;

  void volume_pack(const VolumeView& volume, const std::array<int, 3>& size, int words_per_row,
                   View<std::uint64_t> words) override;
  void points_thin_mask(const BitView& object, View<std::uint64_t> thin,
                        View<std::uint64_t> refine) override;
  void points_mark_bricks(const BitView& object, View<std::uint8_t> octants) override;
  void points_count(const BitView& object, const BitView& refine, const BrickView& bricks,
                    View<std::uint32_t> counts) override;
  void points_emit(const BitView& object, const BitView& thin, const BitView& refine,
                   const BrickView& bricks, View<const std::uint32_t> voxel_start,
                   const Scale& scale, const PointOutput& points) override;

  void normals_gradient(const BitView& object, const PointView& points, const Scale& scale,
                        float sigma, std::array<View<float>, 3> normals) override;
  void normals_covariance(const PointView& points, const BrickView& bricks,
                          View<const std::uint32_t> voxel_start, const Scale& scale, int k,
                          std::array<View<const float>, 3> gradients,
                          std::array<View<float>, 3> normals) override;

  void poisson_apply(const LevelView& level, View<const std::uint8_t> unknown,
                     View<const float> p, View<float> q, View<float> partial) override;
  void poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                        View<const float> b, View<const float> x, View<float> r,
                        View<float> partial) override;
  void poisson_update_solution(const LevelView& level, float alpha, View<const float> p,
                               View<const float> q, View<float> x, View<float> r,
                               View<float> partial) override;
  void poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                View<float> p) override;

 private:
  /// body(i) for i in 0 .. count - 1, in pieces of `grain`, on the arena's workers.
  template <class Body>
  void for_each(std::size_t count, std::size_t grain, const Body& body) {
    if (count == 0) return;
    arena_->execute([&] {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                        [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
                        });
    });
  }

  std::unique_ptr<tbb::task_arena> own_arena_;
  tbb::task_arena* arena_;
  std::atomic<std::size_t> held_{0}, peak_{0};
  std::size_t limit_ = 0;
};

}  // namespace vasamesh

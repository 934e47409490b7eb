#pragma once

/// \file
/// The oneTBB backend's class; its passes are in a file a stage beside this one.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "backend/backend.h"
#include "tbb/task_order.h"

namespace vasamesh {

class TbbBackend final : public Backend {
 public:
  TbbBackend(int threads, void* task_arena, std::shared_ptr<ByteAccount> total);
  ~TbbBackend() override { give_back_kept(); }

  std::string name() const override { return "tbb"; }
  std::string device() const override;
  bool offers(Stage) const override { return true; }
  std::size_t bytes_held() const override { return account_.held(); }
  std::size_t bytes_peak() const override { return account_.peak(); }
  void set_byte_limit(std::size_t bytes) override;
  void keep_memory(bool keep) override;

  void* allocate(std::size_t bytes) override;
  void release(void* handle, std::size_t bytes) noexcept override;
  void write(void* handle, std::size_t offset, const void* from, std::size_t bytes) override;
  void read(const void* handle, std::size_t offset, void* to, std::size_t bytes) override;

  void run(std::size_t tasks, const std::function<void(std::size_t)>& task) override;

  void fill(View<float> values, float value) override;
  void fill(View<std::uint8_t> values, std::uint8_t value) override;
  void fill(View<std::uint32_t> values, std::uint32_t value) override;
  std::uint32_t exclusive_scan(View<const std::uint32_t> values, View<std::uint32_t> sums) override;
  float reduce_sum(View<const float> values) override;

  void volume_pack(const VolumeView& volume, const std::array<int, 3>& size, int words_per_row,
                   View<std::uint64_t> words) override;
  void points_thin_mask(const BitView& object, View<std::uint64_t> thin,
                        View<std::uint64_t> refine) override;
  void points_mark_bricks(const BitView& object, View<std::uint8_t> octants) override;
  void points_count(const BitView& object, const BitView& refine, const BrickView& bricks,
                    View<std::uint32_t> counts, View<std::uint32_t> refined) override;
  void points_emit(const BitView& object, const BitView& thin, const BitView& refine,
                   const BrickView& bricks, View<const std::uint32_t> voxel_start,
                   const Scale& scale, const PointOutput& points) override;

  void normals_gradient(const BitView& object, const PointView& points, const Scale& scale,
                        float sigma, std::array<View<float>, 3> normals) override;
  void normals_covariance(const PointView& points, const BrickView& bricks,
                          View<const std::uint32_t> voxel_start, const Scale& scale, int k,
                          std::array<View<const float>, 3> gradients,
                          std::array<View<float>, 3> normals) override;

  void poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                        View<const float> b, View<const float> x, View<float> r, View<float> p,
                        View<float> b_square, View<float> r_square) override;
  void poisson_energy(const LevelView& level, View<const std::uint8_t> unknown, View<const float> p,
                      View<float> energy) override;
  void poisson_update_solution(const LevelView& level, View<const std::uint8_t> unknown,
                               float alpha, View<const float> p, View<float> x, View<float> r,
                               View<float> r_square) override;
  void poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                View<float> p) override;

  void octree_mark_unknown(const LevelView& level, bool whole, View<std::uint8_t> unknown) override;
  void poisson_splat(const LevelView& level, const PointIndex& index, const PointView& points,
                     const Scale& scale, const Kernel& kernel,
                     View<float> right_hand_side) override;
  void poisson_restrict(const LevelView& coarse, View<const std::int32_t> children,
                        View<const float> fine_values, View<float> coarse_values) override;
  void poisson_prolong(const LevelView& fine, View<const std::int32_t> parents,
                       View<const float> coarse_values, View<float> fine_values) override;
  void poisson_sample_points(const LevelView& level, const PointIndex& index,
                             const PointView& points, View<const float> coefficients,
                             View<float> values) override;
  void isovalue_splat(const LevelView& level, const PointIndex& index, const PointView& points,
                      View<const float> weights, View<const float> values, View<float> numerator,
                      View<float> denominator) override;
  void isovalue_smooth(const LevelView& level, int axis, float tap, View<const float> in,
                       View<float> out) override;
  void isovalue_divide(float fallback, View<const float> denominator,
                       View<float> numerator) override;
  void field_add(float factor, View<const float> b, View<float> a) override;
  void lattice_mark(const BitView& object, const BrickView& bricks,
                    const std::array<int, 3>& radius, View<std::uint8_t> used) override;
  void lattice_label(const BitView& object, int connectivity, const BrickView& bricks,
                     const std::array<int, 3>& radius, View<std::uint8_t> state) override;
  void lattice_sample(const BrickView& bricks, View<const std::int32_t> in_regular,
                      View<const float> regular, View<const std::int32_t> in_refined,
                      View<const float> refined, View<float> values) override;
  void relabel_count(const BrickView& bricks, View<const std::uint8_t> active,
                     View<const std::uint8_t> state, View<const float> values,
                     View<std::uint32_t> counts) override;
  void relabel_collect(const BrickView& bricks, View<const std::uint8_t> active,
                       View<const std::uint8_t> state, View<const float> values,
                       View<const std::uint32_t> starts, View<std::uint32_t> nodes) override;
  std::uint32_t relabel_sweep(const BrickView& bricks, View<const std::uint8_t> simple,
                              View<const float> values, float threshold,
                              View<const std::uint32_t> nodes, View<std::uint8_t> state,
                              View<std::uint32_t> left) override;
  void relabel_mark(View<const std::uint32_t> nodes, std::uint8_t mark,
                    View<std::uint8_t> marks) override;
  std::uint32_t lattice_mark_narrow(const BrickView& bricks, View<const std::uint8_t> active,
                                    View<const std::uint8_t> simple, const LeastWidths& least,
                                    View<const std::uint8_t> state, View<const float> values,
                                    View<std::uint8_t> marks) override;
  std::uint32_t lattice_mark_far(const BrickView& bricks, View<const std::uint8_t> active,
                                 const Scale& scale, float limit, View<const std::uint8_t> state,
                                 View<const float> values, View<std::uint8_t> marks) override;
  void lattice_blend(const BrickView& bricks, View<const std::uint8_t> marks, float radius,
                     float strength, bool smooth, View<const std::uint8_t> state,
                     View<float> values, View<std::uint8_t> changed) override;
  std::uint32_t lattice_clamp(const BrickView& bricks, float least, View<const std::uint8_t> state,
                              View<float> values) override;
  void surface_count(const BrickView& bricks, View<const std::uint8_t> state,
                     View<std::uint8_t> crossed, View<std::uint16_t> node_start,
                     View<std::uint32_t> vertices, View<std::uint32_t> triangles) override;
  void surface_emit(const BrickView& bricks, View<const std::uint8_t> state,
                    View<const float> values, float margin, View<const std::uint8_t> crossed,
                    View<const std::uint16_t> node_start, View<const std::uint32_t> vertex_start,
                    View<const std::uint32_t> triangle_start, View<float> vertices,
                    View<std::uint32_t> triangles) override;
  void sizing_measure(const FieldView& field, float ample, View<Vec3> positions, View<Vec3> normals,
                      View<float> radii) override;
  void expand_choose(const FieldView& field, std::uint32_t round, bool wake,
                     const FrontView& front) override;
  void expand_claim(const FieldView& field, const FrontView& front) override;
  void expand_propose(const FieldView& field, const SizeView& sizes, const FrontLimits& limits,
                      const FrontView& front) override;
  void expand_add(const FieldView& field, const FrontView& front) override;
  void stitch_triangulate(const GapRules& rules, StitchMode mode, const GapView& gaps,
                          View<std::uint8_t> closed, View<std::uint16_t> triangles) override;
  void relax_smooth(const FieldView& field, const SizeView& sizes, const PlaceView& places,
                    const FanView& fans, int passes, View<SurfacePoint> points) override;
  void relax_equalise(const FieldView& field, const SizeView& sizes, const PlaceView& places,
                      const FanView& fans, int passes, bool onto,
                      View<SurfacePoint> points) override;
  void relax_gaps(const FieldView& field, const FanView& fans, View<const SurfacePoint> points,
                  View<float> gaps) override;
  void verify_count_pairs(const MeshView& mesh, const TreeView& tree,
                          View<std::uint32_t> counts) override;
  void verify_collect_pairs(const MeshView& mesh, const TreeView& tree,
                            View<const std::uint32_t> starts, View<std::uint32_t> pairs) override;

 private:
  /// body(i) for i in 0 .. count - 1, in pieces of `grain`, on the arena's workers; a checkpoint
  /// before each piece.
  template <class Body>
  void for_each(std::size_t count, std::size_t grain, const Body& body) {
    if (count == 0) return;
    const auto run_range = [&](const tbb::blocked_range<std::size_t>& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        if (i % grain == 0) checkpoint();
        body(i);
      }
    };
    TaskOrder order;
    arena_->execute([&] {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), order.around(run_range));
    });
  }

  void copy(void* to, const void* from, std::size_t bytes);
  template <class T>
  void fill_blocks(View<T> values, T value);
  void give_back_kept();

  /// A kept block of that size, or a new one; null where there is no memory.
  void* take_block(std::size_t size);
  /// \return whether it is kept.
  bool keep_block(void* block, std::size_t size) noexcept;

  std::unique_ptr<tbb::task_arena> own_arena_;
  tbb::task_arena* arena_;
  ByteAccount account_;

  std::mutex kept_mutex_;
  int keepers_ = 0;       ///< who asked for it, and still does
  bool limited_ = false;  ///< what is kept would count
  std::size_t kept_bytes_ = 0;
  std::unordered_map<std::size_t, std::vector<void*>> kept_;  ///< blocks by their size
};

}  // namespace vasamesh

#pragma once

/// \file
/// The OpenCL backend's class; its passes are in a file a stage beside this one. Passes are queued
/// in order and return at once; what reads a value back waits, and reports what went wrong before
/// it.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>

#include "backend/backend.h"
#include "opencl/backend.h"
#include "opencl/check.h"
#include "opencl/device_memory.h"
#include "opencl/program.h"
#include "types/tetrahedra.h"

namespace vasamesh {

/// All devices of all platforms; their opencl_index counts them so. Every use of OpenCL begins
/// here: the first call gives PoCL its folder (pocl.h).
std::vector<cl::Device> opencl_devices();

/// What kernels of that shape need and the device has not, as "has work-groups of at most 1 item,
/// not 64"; empty when it has everything. Kernels need no doubles.
std::string lacks(const cl::Device& device, const WorkShape& shape);

/// \throws DeviceFailure no_device, where it lacks something.
void refuse_lacking(const cl::Device& device, const WorkShape& shape);

class OpenClBackend final : public Backend {
 public:
  /// \param copies  what options.copies comes to on the device; not by_device.
  /// \param options  of which `device`, `shape`, `work_shape` and `copies` are ignored: the other
  ///        parameters say what they came to.
  OpenClBackend(cl::Device device, const WorkShape& shape, DeviceCopies copies,
                const OpenClOptions& options);
  ~OpenClBackend() override;

  std::string name() const override { return "opencl"; }
  std::string device() const override { return device_name_; }
  std::string other_arithmetic() const override { return other_arithmetic_; }
  bool offers(Stage stage) const override {
    return stage < Stage::mesh && (stages_ & bit_of(stage));
  }
  std::size_t memory() const override { return global_memory_; }
  std::size_t bytes_held() const override { return account_.held(); }
  std::size_t bytes_peak() const override { return account_.peak(); }
  void set_byte_limit(std::size_t bytes) override { account_.set_limit(bytes); }

  void* allocate(std::size_t bytes) override;
  void release(void* handle, std::size_t bytes) noexcept override;
  void settle() override { memory_->settle(); }
  Traffic traffic() const override;
  void finish() override { memory_->wait(); }
  void set_checkpoint(std::function<void()> checkpoint) override;
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
  void bring_to_host(void* handle, bool writes) override { memory_->bring_to_host(handle, writes); }

  template <class T>
  void fill_view(View<T> values, T value);

  /// Groups of passes over elements: groups of fold_items.
  std::size_t groups_of(std::size_t elements) const {
    const auto items = static_cast<std::size_t>(shape_.fold_items);
    return (elements + items - 1) / items;
  }

  /// Queues `groups` work-groups of `items`; a view is passed as its memory and its first element,
  /// an array as its entries.
  template <class... Arguments>
  void launch(const char* name, std::size_t groups, int items, const Arguments&... arguments) {
    if (groups == 0) return;
    cl::Kernel& kernel = programs_->kernel(name);
    memory_->command([&] {
      cl_uint index = 0;
      (set(kernel, index, arguments), ...);
      check(queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(groups * items),
                                        cl::NDRange(items)),
            std::string(name) + " on " + device_name_);
      ++launches_;
    });
  }
  template <class T>
  cl_mem memory_of(const View<T>& view) {
    return memory_->on_device(view.handle, (view.offset + view.size) * sizeof(T),
                              !std::is_const_v<T>);
  }
  template <class T>
  void set(cl::Kernel& kernel, cl_uint& index, const View<T>& view) {
    const cl_mem memory = memory_of(view);
    const cl_ulong first = view.offset;
    set_bytes(kernel, index++, sizeof(memory), &memory);
    set_bytes(kernel, index++, sizeof(first), &first);
  }
  template <class T, std::size_t n>
  void set(cl::Kernel& kernel, cl_uint& index, const std::array<View<T>, n>& views) {
    for (const View<T>& view : views) set(kernel, index, view);
  }
  /// FIELD_VIEW of kernels/field.cl.
  void set(cl::Kernel& kernel, cl_uint& index, const FieldView& field) {
    const Scale& inverse = field.inverse_step;
    set(kernel, index, cl_int4{{field.grid[0], field.grid[1], field.grid[2], 0}});
    set(kernel, index, cl_float4{{inverse[0], inverse[1], inverse[2], 0}});
    set(kernel, index, field.brick_at);
    set(kernel, index, field.coefficients);
  }
  /// FRONT_VIEW of kernels/expand_front.cl.
  void set(cl::Kernel& kernel, cl_uint& index, const FrontView& front) {
    set(kernel, index, front.counts);
    set(kernel, index, front.vertices);
    set(kernel, index, front.corners);
    for (const View<std::uint32_t>& list :
         {front.triangles, front.listed, front.alive, front.chosen})
      set(kernel, index, list);
    set(kernel, index, front.proposals);
    set(kernel, index, front.starts);
    set(kernel, index, front.claims);
    set(kernel, index, front.edge_at);
    set(kernel, index, front.vertex_at);
  }
  /// SIZES_VIEW of kernels/field.cl.
  void set(cl::Kernel& kernel, cl_uint& index, const SizeView& view) {
    const std::array<int, 3>& grid = view.field.grid;
    const Scale& inverse = view.field.inverse_step;
    set(kernel, index, cl_int4{{grid[0], grid[1], grid[2], 0}});
    set(kernel, index, cl_float4{{inverse[0], inverse[1], inverse[2], view.elsewhere}});
    set(kernel, index, view.field.brick_at);
    set(kernel, index, view.sizes);
    set(kernel, index, cl_ulong{view.sizes.size});
  }
  /// The places of RELAX_GOAL in kernels/relax.cl.
  void set(cl::Kernel& kernel, cl_uint& index, const PlaceView& view) {
    set(kernel, index, view.cells);
    set(kernel, index, view.places);
    set(kernel, index, cl_ulong{view.cells.size});
  }
  /// The tree of VERIFY_TREE in kernels/verify.cl.
  void set(cl::Kernel& kernel, cl_uint& index, const TreeView& view) {
    set(kernel, index, view.order);
    set(kernel, index, view.nodes);
    set(kernel, index, view.level_first);
    set(kernel, index, cl_ulong{view.order.size});
    set(kernel, index, cl_int{view.levels()});
  }
  template <class T>
  void set(cl::Kernel& kernel, cl_uint& index, const T& value) {
    set_bytes(kernel, index++, sizeof(value), &value);
  }
  void set_bytes(cl::Kernel& kernel, cl_uint index, std::size_t size, const void* value) {
    check(kernel.setArg(index, size, value), "setting an argument on " + device_name_);
  }

  /// Counts of a pass's groups, and their sum.
  View<std::uint32_t> counts_of(std::size_t count);
  std::uint32_t sum_of_counts();

  View<const CubeCase> cube_cases();

  cl::Device device_;
  std::string device_name_, other_arithmetic_;
  std::size_t largest_buffer_, global_memory_;
  cl::Context context_;
  cl::CommandQueue queue_;
  WorkShape shape_;
  std::optional<Programs> programs_;
  std::optional<DeviceMemory> memory_;
  std::shared_ptr<Backend> workers_;
  std::int64_t launches_ = 0;
  std::uint32_t stages_;  ///< bit_of those that it offers
  ByteAccount account_;
  Buffer<float> sums_;            // of reduce_sum
  Buffer<std::uint64_t> totals_;  // of exclusive_scan, a block an entry
  Buffer<std::uint32_t> counts_;
  Buffer<CubeCase> cube_cases_;
  Buffer<std::uint8_t> marks_;  // of expand_choose, a corner of the list an entry
  Buffer<cl_uint2> blocks_;     // and a block of it
};

}  // namespace vasamesh

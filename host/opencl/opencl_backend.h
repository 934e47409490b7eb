#pragma once

/// \file
/// The OpenCL backend's class; its passes are in a file a stage beside this one. A buffer's handle
/// is its cl_mem. Passes are queued in order and return at once; what reads a value back waits, and
/// reports what went wrong before it.

#include <optional>
#include <string>

#include "backend/partial_backend.h"
#include "opencl/backend.h"
#include "opencl/check.h"
#include "opencl/program.h"

namespace vasamesh {

/// All devices of all platforms; list_opencl_devices() numbers them so.
std::vector<cl::Device> opencl_devices();

/// What kernels of that shape need and the device has not, as "has work-groups of at most 1 item,
/// not 64"; empty when it has everything. Kernels need no doubles.
std::string lacks(const cl::Device& device, const WorkShape& shape);

class OpenClBackend final : public PartialBackend {
 public:
  OpenClBackend(cl::Device device, const WorkShape& shape, ProgramCache cache);

  std::string name() const override { return "opencl"; }
  std::string device() const override { return device_name_; }
  bool offers(Stage stage) const override { return stage == Stage::poisson; }
  std::size_t bytes_held() const override { return held_; }
  std::size_t bytes_peak() const override { return peak_; }
  void set_byte_limit(std::size_t bytes) override { limit_ = bytes; }

  void* allocate(std::size_t bytes) override;
  void release(void* handle, std::size_t bytes) noexcept override;
  void write(void* handle, std::size_t offset, const void* from, std::size_t bytes) override;
  void read(const void* handle, std::size_t offset, void* to, std::size_t bytes) override;

  void fill(View<float> values, float value) override;
  void fill(View<std::uint8_t> values, std::uint8_t value) override;
  void fill(View<std::uint32_t> values, std::uint32_t value) override;
  std::uint32_t exclusive_scan(View<const std::uint32_t> values, View<std::uint32_t> sums) override;
  float reduce_sum(View<const float> values) override;

  void poisson_apply(const LevelView& level, View<const std::uint8_t> unknown, View<const float> p,
                     View<float> q, View<float> partial) override;
  void poisson_residual(const LevelView& level, View<const std::uint8_t> unknown,
                        View<const float> b, View<const float> x, View<float> r,
                        View<float> partial) override;
  void poisson_update_solution(const LevelView& level, float alpha, View<const float> p,
                               View<const float> q, View<float> x, View<float> r,
                               View<float> partial) override;
  void poisson_update_direction(const LevelView& level, float beta, View<const float> r,
                                View<float> p) override;

 private:
  template <class T>
  void fill_view(View<T> values, T value);

  /// Queues `groups` work-groups of `items`; a view is passed as its memory and its first element.
  template <class... Arguments>
  void launch(const char* name, std::size_t groups, int items, const Arguments&... arguments) {
    if (groups == 0) return;
    cl::Kernel& kernel = programs_->kernel(name);
    cl_uint index = 0;
    (set(kernel, index, arguments), ...);
    check(queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(groups * items),
                                      cl::NDRange(items)),
          std::string(name) + " on " + device_name_);
  }
  template <class T>
  void set(cl::Kernel& kernel, cl_uint& index, const View<T>& view) {
    const auto memory = static_cast<cl_mem>(view.handle);
    const cl_ulong first = view.offset;
    set_bytes(kernel, index++, sizeof(memory), &memory);
    set_bytes(kernel, index++, sizeof(first), &first);
  }
  template <class T>
  void set(cl::Kernel& kernel, cl_uint& index, const T& value) {
    set_bytes(kernel, index++, sizeof(value), &value);
  }
  void set_bytes(cl::Kernel& kernel, cl_uint index, std::size_t size, const void* value) {
    check(kernel.setArg(index, size, value), "setting an argument on " + device_name_);
  }

  cl::Device device_;
  std::string device_name_;
  std::size_t largest_buffer_;
  cl::Context context_;
  cl::CommandQueue queue_;
  WorkShape shape_;
  std::optional<Programs> programs_;
  std::size_t held_ = 0, peak_ = 0, limit_ = 0;
  Buffer<float> sums_;            // of reduce_sum
  Buffer<std::uint64_t> totals_;  // of exclusive_scan, a block an entry
};

}  // namespace vasamesh

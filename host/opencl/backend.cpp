#include "opencl/backend.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "backend/device_failure.h"
#include "opencl/arithmetic.h"
#include "opencl/opencl_backend.h"
#include "opencl/pocl.h"
#include "opencl/tuning.h"

namespace vasamesh {

namespace {

constexpr std::size_t kReduceLast = 8192;  // sums that one work-group adds

std::size_t pieces(std::size_t count, std::size_t size) { return (count + size - 1) / size; }

WorkShape usual_shape(const cl::Device& device) {
  return is_cpu(device) ? kOneItemShape : kWorkGroupShape;
}

WorkShape shape_for(const cl::Device& device, const OpenClOptions& options) {
  if (options.work_shape) return *options.work_shape;
  if (options.shape == KernelShape::one_item) return kOneItemShape;
  if (options.shape == KernelShape::work_group) return kWorkGroupShape;
  return load_shape(options.device, options.cache_folder).value_or(usual_shape(device));
}

DeviceCopies copies_on(const cl::Device& device, DeviceCopies wanted) {
  if (wanted != DeviceCopies::by_device) return wanted;
  if (is_cpu(device)) return DeviceCopies::shared;
  cl_bool unified = CL_FALSE;  // a question that later versions may not answer
  if (device.getInfo(CL_DEVICE_HOST_UNIFIED_MEMORY, &unified) != CL_SUCCESS || !unified)
    return DeviceCopies::separate;
  return DeviceCopies::mapped;
}

std::function<void()> opening_checkpoint(const std::atomic<bool>* cancel) {
  if (!cancel) return {};
  return [cancel] {
    if (cancel->load(std::memory_order_relaxed))
      throw Error(ErrorCode::cancelled, "cancelled while a device was opened");
  };
}

}  // namespace

WorkShape usual_opencl_shape(int device) {
  return usual_shape(opencl_devices().at(static_cast<std::size_t>(device)));
}

std::shared_ptr<Backend> make_opencl_backend(const OpenClOptions& options) {
  const std::vector<cl::Device> devices = opencl_devices();
  if (devices.empty())
    throw Error(ErrorCode::no_device,
                "no OpenCL device: " + opencl_remedy() + ", or use --backend tbb");
  if (options.device < 0 || static_cast<std::size_t>(options.device) >= devices.size())
    throw Error(ErrorCode::no_device, "no OpenCL device " + std::to_string(options.device) +
                                          " of " + std::to_string(devices.size()) +
                                          ": see vasamesh devices, or use --backend tbb");
  const cl::Device& device = devices[static_cast<std::size_t>(options.device)];
  try {
    return std::make_shared<OpenClBackend>(device, shape_for(device, options),
                                           copies_on(device, options.copies), options);
  } catch (const DeviceFailure& failure) {
    throw Error(ErrorCode::no_device, std::string("the OpenCL device cannot be opened: ") +
                                          failure.what() + "; see vasamesh devices");
  }
}

OpenClBackend::OpenClBackend(cl::Device device, const WorkShape& shape, DeviceCopies copies,
                             const OpenClOptions& options)
    : device_(std::move(device)),
      device_name_(ask<CL_DEVICE_NAME>(device_)),
      largest_buffer_(ask<CL_DEVICE_MAX_MEM_ALLOC_SIZE>(device_)),
      global_memory_(ask<CL_DEVICE_GLOBAL_MEM_SIZE>(device_)),
      shape_(shape),
      workers_(options.workers),
      stages_(options.stages),
      account_(options.total) {
  refuse_lacking(device_, shape_);
  cl_int status = CL_SUCCESS;
  context_ = cl::Context(device_, nullptr, nullptr, nullptr, &status);
  check(status, "a context on " + device_name_);
  queue_ = cl::CommandQueue(context_, device_, 0, &status);
  check(status, "a queue on " + device_name_);
  programs_.emplace(context_, device_, shape_, cache_for(device_, options.cache_folder));
  programs_->set_checkpoint(opening_checkpoint(options.cancel));
  memory_.emplace(context_, queue_, device_name_, copies);
  other_arithmetic_ = vasamesh::other_arithmetic(context_, queue_, *programs_);
  if (!other_arithmetic_.empty()) {
    if (!options.any_arithmetic)
      throw DeviceFailure(ErrorCode::no_device, device_name_ + " " + other_arithmetic_ +
                                                    ", so that its surfaces differ from other "
                                                    "devices': use --backend tbb");
    stages_ &= ~bit_of(Stage::verify);
  }
  programs_->set_checkpoint({});
}

/// A program that keeps its Context to the end has its kernels recorded then.
OpenClBackend::~OpenClBackend() { record_pocl_kernels(); }

Traffic OpenClBackend::traffic() const {
  return {launches_, memory_->copies(), memory_->bytes_copied(), memory_->waited()};
}

void* OpenClBackend::allocate(std::size_t bytes) {
  if (bytes > largest_buffer_)
    throw DeviceFailure(ErrorCode::refused, device_name_ + " gives buffers of at most " +
                                                std::to_string(largest_buffer_) + " bytes, not " +
                                                std::to_string(bytes) + ": use --backend tbb");
  account_.take(bytes);
  try {
    return memory_->allocate(bytes);
  } catch (...) {
    account_.give(bytes);
    throw;
  }
}

void OpenClBackend::set_checkpoint(std::function<void()> checkpoint) {
  memory_->set_checkpoint(checkpoint);
  programs_->set_checkpoint(checkpoint);
  if (workers_) workers_->set_checkpoint(checkpoint);
  Backend::set_checkpoint(std::move(checkpoint));
}

void OpenClBackend::release(void* handle, std::size_t bytes) noexcept {
  account_.give(bytes);
  memory_->release(handle);
}

void OpenClBackend::write(void* handle, std::size_t offset, const void* from, std::size_t bytes) {
  memory_->write(handle, offset, from, bytes);
}

void OpenClBackend::read(const void* handle, std::size_t offset, void* to, std::size_t bytes) {
  memory_->read(handle, offset, to, bytes);
}

void OpenClBackend::run(std::size_t tasks, const std::function<void(std::size_t)>& task) {
  memory_->wait();
  if (workers_)
    workers_->run(tasks, task);
  else
    for (std::size_t i = 0; i < tasks; ++i) task(i);
}

template <class T>
void OpenClBackend::fill_view(View<T> values, T value) {
  if (values.size == 0) return;
  memory_->command([&] {
    check(clEnqueueFillBuffer(queue_(), memory_of(values), &value, sizeof(T),
                              values.offset * sizeof(T), values.size * sizeof(T), 0, nullptr,
                              nullptr),
          "fill on " + device_name_);
  });
}

void OpenClBackend::fill(View<float> values, float value) { fill_view(values, value); }

void OpenClBackend::fill(View<std::uint8_t> values, std::uint8_t value) {
  fill_view(values, value);
}

void OpenClBackend::fill(View<std::uint32_t> values, std::uint32_t value) {
  fill_view(values, value);
}

/// Totals of the blocks are scanned here: the caller waits for the sum of all anyhow.
std::uint32_t OpenClBackend::exclusive_scan(View<const std::uint32_t> values,
                                            View<std::uint32_t> sums) {
  const std::size_t blocks = pieces(values.size, static_cast<std::size_t>(shape_.scan_block()));
  std::vector<std::uint64_t> starts(blocks + 1);  // of the blocks, and the sum of all
  const std::span totals = std::span(starts).first(blocks);
  const cl_ulong count = values.size;
  if (blocks) {
    totals_.resize(*this, blocks);
    launch("primitives_scan_totals", blocks, shape_.scan_items, values, count, totals_.view());
    download<std::uint64_t>(totals_.view(), totals);
  }
  std::exclusive_scan(starts.begin(), starts.end(), starts.begin(), std::uint64_t{0});
  if (starts.back() > 0xffffffffu)
    throw Error(ErrorCode::refused, "more than 2^32 elements: convert a part of the volume");
  if (blocks) {
    upload<std::uint64_t>(totals_.view(), totals);
    launch("primitives_scan_blocks", blocks, shape_.scan_items, values, count, totals_.view(),
           sums);
  }
  const auto total = static_cast<std::uint32_t>(starts.back());
  upload<std::uint32_t>(sums.subview(values.size, 1), {&total, 1});
  return total;
}

float OpenClBackend::reduce_sum(View<const float> values) {
  float sum = 0;
  if (values.size == 0) return sum;
  if (values.size == 1) {
    download<float>(values, {&sum, 1});
    return sum;
  }
  const cl_ulong count = values.size;
  cl_ulong half = std::bit_ceil(values.size) / 2;
  sums_.resize(*this, half);
  launch("primitives_reduce_first", groups_of(half), shape_.fold_items, values, count, half,
         sums_.view());
  for (half /= 2; half > kReduceLast; half /= 2)
    launch("primitives_reduce_fold", groups_of(half), shape_.fold_items, sums_.view(), half);
  if (half)
    launch("primitives_reduce_last", 1, shape_.reduce_items, sums_.view(),
           static_cast<cl_uint>(half));
  download<float>(sums_.view().subview(0, 1), {&sum, 1});
  return sum;
}

}  // namespace vasamesh

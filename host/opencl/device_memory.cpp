#include "opencl/device_memory.h"

#include <chrono>
#include <cstring>
#include <new>
#include <utility>

#include "opencl/wait.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::align_val_t kPage{4096};  // what devices ask for that shall work in host memory

}  // namespace

DeviceMemory::DeviceMemory(cl::Context context, cl::CommandQueue queue, std::string device,
                           bool shared)
    : context_(std::move(context)),
      queue_(std::move(queue)),
      device_(std::move(device)),
      shared_(shared),
      pinned_(context_, queue_, device_) {}

/// What the device may still use when it does not answer any more is never freed.
DeviceMemory::~DeviceMemory() {
  if (!left_.empty() && queue_.finish() == CL_SUCCESS) give_back_left();
}

void DeviceMemory::wait() {
  if (idle_) return;
  const auto start = std::chrono::steady_clock::now();
  wait_for(queue_, checkpoint_, device_);
  waited_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  idle_ = true;
  give_back_left();
}

void* DeviceMemory::allocate(std::size_t bytes) {
  if (!left_.empty()) wait();
  void* host = ::operator new(bytes, kPage, std::nothrow);
  if (!host)
    throw Error(ErrorCode::refused,
                "out of memory: " + std::to_string(bytes) + " bytes could not be had");
  try {
    allocations_[host] = {
        create(bytes, shared_ ? CL_MEM_USE_HOST_PTR : 0, shared_ ? host : nullptr), bytes};
  } catch (...) {
    ::operator delete(host, kPage);
    throw;
  }
  return host;
}

/// Commands that are queued may still use memory that is shared: it is kept until a wait is over.
void DeviceMemory::release(void* handle) noexcept {
  const auto found = allocations_.find(handle);
  const Allocation allocation = found->second;
  allocations_.erase(found);
  if (shared_ && !idle_)
    left_.emplace_back(handle, allocation);
  else
    give_back(handle, allocation);
}

void DeviceMemory::give_back(void* handle, const Allocation& allocation) {
  clReleaseMemObject(allocation.memory);
  ::operator delete(handle, kPage);
}

void DeviceMemory::give_back_left() {
  for (const auto& [handle, allocation] : left_) give_back(handle, allocation);
  left_.clear();
}

cl_mem DeviceMemory::on_device(void* handle, std::size_t bytes, bool writes) {
  if (!handle) return nullptr;
  Allocation* own = find(handle);
  if (own && own->device_stale) copy_in(own->memory, 0, handle, own->bytes);
  if (!own) return lend(handle, bytes, writes);
  if (shared_) return own->memory;
  own->device_stale = false;
  own->host_stale |= writes;
  return own->memory;
}

/// Takes back what was lent. What is not ours may be freed once we return: there is no leaving
/// before the end. Nor does a loan outlive what is thrown here.
void DeviceMemory::finish_loans() {
  const std::vector<Loan> loans = std::exchange(loans_, {});
  if (loans.empty()) return;
  try {
    wait();
  } catch (...) {
    queue_.finish();
    throw;
  }
  for (const Loan& loan : loans)
    if (loan.writes && !shared_) copy_out(loan.memory(), 0, loan.address, loan.bytes);
}

void DeviceMemory::bring_to_host(void* handle, bool writes) {
  wait();
  Allocation* own = shared_ ? nullptr : find(handle);
  if (!own) return;
  copy_to_host(handle, *own);
  own->device_stale |= writes;
}

void DeviceMemory::settle() {
  wait();
  if (shared_) return;
  for (auto& [handle, own] : allocations_) {
    copy_to_host(const_cast<void*>(handle), own);
    own.device_stale = true;
  }
}

void DeviceMemory::write(void* handle, std::size_t offset, const void* from, std::size_t bytes) {
  const Allocation* own = find(handle);
  if (own && shared_) wait();
  if (!own || shared_ || !own->host_stale)
    std::memcpy(static_cast<std::byte*>(handle) + offset, from, bytes);
  if (own && !shared_ && !own->device_stale) copy_in(own->memory, offset, from, bytes);
}

void DeviceMemory::read(const void* handle, std::size_t offset, void* to, std::size_t bytes) {
  const Allocation* own = find(handle);
  if (own && !shared_ && !own->device_stale) return copy_out(own->memory, offset, to, bytes);
  if (own && shared_) wait();
  std::memcpy(to, static_cast<const std::byte*>(handle) + offset, bytes);
}

void DeviceMemory::copy_in(cl_mem memory, std::size_t offset, const void* from, std::size_t bytes) {
  wait();
  pinned_.to_device(from, bytes, memory, offset, checkpoint_);
  count_copy(bytes);
}

void DeviceMemory::copy_out(cl_mem memory, std::size_t offset, void* to, std::size_t bytes) {
  wait();
  pinned_.to_host(memory, offset, to, bytes, checkpoint_);
  count_copy(bytes);
}

void DeviceMemory::count_copy(std::size_t bytes) {
  ++copies_;
  bytes_copied_ += static_cast<std::int64_t>(bytes);
}

cl_mem DeviceMemory::create(std::size_t bytes, cl_mem_flags flags, void* host) {
  cl_int status = CL_SUCCESS;
  cl_mem memory = clCreateBuffer(context_(), CL_MEM_READ_WRITE | flags, bytes, host, &status);
  check(status, "allocating " + std::to_string(bytes) + " bytes on " + device_);
  return memory;
}

cl_mem DeviceMemory::lend(void* address, std::size_t bytes, bool writes) {
  const cl_mem memory =
      create(bytes, shared_ ? CL_MEM_USE_HOST_PTR : 0, shared_ ? address : nullptr);
  loans_.push_back({cl::Buffer(memory), address, bytes, writes});
  if (!shared_) copy_in(memory, 0, address, bytes);
  return memory;
}

void DeviceMemory::copy_to_host(void* handle, Allocation& own) {
  if (!own.host_stale) return;
  copy_out(own.memory, 0, handle, own.bytes);
  own.host_stale = false;
}

/// Null for another backend's memory.
DeviceMemory::Allocation* DeviceMemory::find(const void* handle) {
  const auto found = allocations_.find(handle);
  return found == allocations_.end() ? nullptr : &found->second;
}

}  // namespace vasamesh

#include "opencl/device_memory.h"

#include <algorithm>
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
                           DeviceCopies copies)
    : context_(std::move(context)),
      queue_(std::move(queue)),
      device_(std::move(device)),
      where_(copies),
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
    allocations_[host] = {create(bytes, host), bytes, is_mapped()};
  } catch (...) {
    ::operator delete(host, kPage);
    throw;
  }
  return host;
}

/// Commands that are queued may still use the host's memory: it is kept until a wait is over.
void DeviceMemory::release(void* handle) noexcept {
  const auto found = allocations_.find(handle);
  const Allocation allocation = found->second;
  allocations_.erase(found);
  if (is_mapped() && allowed(allocation) != HostMay::nothing) unmap(allocation.memory, handle);
  if (!is_separate() && !idle_)
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
  if (!own) return lend(handle, bytes, writes);
  if (is_shared()) return own->memory;
  if (is_mapped()) {
    let_host(std::min(allowed(*own), writes ? HostMay::nothing : HostMay::read), handle, *own);
    return own->memory;
  }
  if (own->device_stale) copy_in(own->memory, 0, handle, own->bytes);
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
  for (const Loan& loan : loans) {
    if (!loan.writes) continue;
    if (is_separate()) copy_out(loan.memory(), 0, loan.address, loan.bytes);
    if (!is_mapped()) continue;
    map(loan.memory(), loan.bytes, HostMay::read);
    check(unmap(loan.memory(), loan.address), "taking memory back from " + device_);
  }
  if (idle_) return;
  check(queue_.finish(), "taking memory back from " + device_);
  idle_ = true;
  give_back_left();
}

void DeviceMemory::bring_to_host(void* handle, bool writes) {
  wait();
  Allocation* own = is_shared() ? nullptr : find(handle);
  if (!own) return;
  if (is_mapped())
    return let_host(std::max(allowed(*own), writes ? HostMay::write : HostMay::read), handle, *own);
  copy_to_host(handle, *own);
  own->device_stale |= writes;
}

void DeviceMemory::settle() {
  wait();
  if (is_shared()) return;
  for (auto& [handle, own] : allocations_) {
    void* const host = const_cast<void*>(handle);
    if (is_mapped()) {
      let_host(HostMay::write, host, own);
      continue;
    }
    copy_to_host(host, own);
    own.device_stale = true;
  }
}

void DeviceMemory::write(void* handle, std::size_t offset, const void* from, std::size_t bytes) {
  const Allocation* own = find(handle);
  if (own && !is_separate()) bring_to_host(handle, true);
  if (!own || !own->host_stale) std::memcpy(static_cast<std::byte*>(handle) + offset, from, bytes);
  if (own && is_separate() && !own->device_stale) copy_in(own->memory, offset, from, bytes);
}

void DeviceMemory::read(const void* handle, std::size_t offset, void* to, std::size_t bytes) {
  const Allocation* own = find(handle);
  if (own && is_separate() && !own->device_stale) return copy_out(own->memory, offset, to, bytes);
  if (own && !is_separate()) bring_to_host(const_cast<void*>(handle), false);
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

/// As much memory on the device, or that of the host.
cl_mem DeviceMemory::create(std::size_t bytes, void* host) {
  cl_int status = CL_SUCCESS;
  cl_mem memory =
      clCreateBuffer(context_(), CL_MEM_READ_WRITE | (is_separate() ? 0 : CL_MEM_USE_HOST_PTR),
                     bytes, is_separate() ? nullptr : host, &status);
  check(status, "allocating " + std::to_string(bytes) + " bytes on " + device_);
  return memory;
}

cl_mem DeviceMemory::lend(void* address, std::size_t bytes, bool writes) {
  const cl_mem memory = create(bytes, address);
  loans_.push_back({cl::Buffer(memory), address, bytes, writes});
  if (is_separate()) copy_in(memory, 0, address, bytes);
  return memory;
}

DeviceMemory::HostMay DeviceMemory::allowed(const Allocation& own) {
  if (own.host_stale) return HostMay::nothing;
  return own.device_stale ? HostMay::write : HostMay::read;
}

/// Returns when the commands before have ended.
void DeviceMemory::map(cl_mem memory, std::size_t bytes, HostMay what) {
  cl_int status = CL_SUCCESS;
  clEnqueueMapBuffer(queue_(), memory, CL_TRUE,
                     what == HostMay::write ? CL_MAP_READ | CL_MAP_WRITE : CL_MAP_READ, 0, bytes, 0,
                     nullptr, nullptr, &status);
  check(status, "mapping memory of " + device_);
  idle_ = true;
  give_back_left();
}

cl_int DeviceMemory::unmap(cl_mem memory, void* host) {
  idle_ = false;
  return clEnqueueUnmapMemObject(queue_(), memory, host, 0, nullptr, nullptr);
}

void DeviceMemory::let_host(HostMay what, void* handle, Allocation& own) {
  const HostMay before = allowed(own);
  if (what == before) return;
  if (what != HostMay::nothing) wait();
  if (before != HostMay::nothing) check(unmap(own.memory, handle), "giving memory to " + device_);
  own.host_stale = true;
  own.device_stale = false;
  if (what == HostMay::nothing) return;
  map(own.memory, own.bytes, what);
  own.host_stale = false;
  own.device_stale = what == HostMay::write;
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

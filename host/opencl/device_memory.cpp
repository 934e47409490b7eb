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
    allocations_[host] = {create(bytes, host), bytes,
                          is_mapped() ? HostMay::nothing : HostMay::read};
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
  if (is_mapped() && allocation.host != HostMay::nothing) unmap(allocation.memory, handle);
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
  if (!is_shared())
    let_host(std::min(own->host, writes ? HostMay::nothing : HostMay::read), handle, *own);
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
  if (own) let_host(std::max(own->host, writes ? HostMay::write : HostMay::read), handle, *own);
}

void DeviceMemory::settle() {
  wait();
  if (is_shared()) return;
  for (auto& [handle, own] : allocations_) let_host(HostMay::write, const_cast<void*>(handle), own);
}

void DeviceMemory::write(void* handle, std::size_t offset, const void* from, std::size_t bytes) {
  const Allocation* own = find(handle);
  if (own && !is_separate()) bring_to_host(handle, true);
  if (!own || own->host != HostMay::nothing)
    std::memcpy(static_cast<std::byte*>(handle) + offset, from, bytes);
  if (own && is_separate() && own->host != HostMay::write)
    copy_in(own->memory, offset, from, bytes);
}

void DeviceMemory::read(const void* handle, std::size_t offset, void* to, std::size_t bytes) {
  const Allocation* own = find(handle);
  if (own && is_separate() && own->host != HostMay::write)
    return copy_out(own->memory, offset, to, bytes);
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

/// The device gets mapped memory, and the host at once what it may have of it.
void DeviceMemory::remap(HostMay what, void* handle, Allocation& own) {
  if (what != HostMay::nothing) wait();
  if (own.host != HostMay::nothing) check(unmap(own.memory, handle), "giving memory to " + device_);
  own.host = HostMay::nothing;
  if (what != HostMay::nothing) map(own.memory, own.bytes, what);
  own.host = what;
}

void DeviceMemory::let_host(HostMay what, void* handle, Allocation& own) {
  if (what == own.host) return;
  if (is_mapped()) return remap(what, handle, own);
  if (own.host == HostMay::write) copy_in(own.memory, 0, handle, own.bytes);
  if (own.host == HostMay::nothing) copy_out(own.memory, 0, handle, own.bytes);
  own.host = what;
}

/// Null for another backend's memory.
DeviceMemory::Allocation* DeviceMemory::find(const void* handle) {
  const auto found = allocations_.find(handle);
  return found == allocations_.end() ? nullptr : &found->second;
}

}  // namespace vasamesh

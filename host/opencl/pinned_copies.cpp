#include "opencl/pinned_copies.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace vasamesh {

namespace {

constexpr std::size_t kBlock = 4 << 20;  // bytes
constexpr std::size_t kSmall = 1 << 16;  // bytes that go straight

/// How many bytes the block from `first` on takes.
std::size_t bytes_at(std::size_t first, std::size_t bytes) {
  return std::min(kBlock, bytes - first);
}

}  // namespace

PinnedCopies::PinnedCopies(cl::Context context, cl::CommandQueue queue, std::string device)
    : context_(std::move(context)), queue_(std::move(queue)), device_(std::move(device)) {}

PinnedCopies::~PinnedCopies() {
  for (const Block& block : blocks_)
    if (block.copied) clReleaseEvent(block.copied);
  if (!pinned_) return;
  if (blocks_[0].bytes)
    clEnqueueUnmapMemObject(queue_(), pinned_, blocks_[0].bytes, 0, nullptr, nullptr);
  clReleaseMemObject(pinned_);
}

void PinnedCopies::to_device(const void* from, std::size_t bytes, cl_mem memory, std::size_t offset,
                             const std::function<void()>& checkpoint) {
  const std::string what = copying(bytes, "to");
  if (bytes <= kSmall)
    return check(
        clEnqueueWriteBuffer(queue_(), memory, CL_TRUE, offset, bytes, from, 0, nullptr, nullptr),
        what);
  open();
  for (std::size_t first = 0; first < bytes; first += kBlock) {
    Block& block = blocks_[first / kBlock % 2];
    wait_for(block);
    if (checkpoint) checkpoint();
    const std::size_t count = bytes_at(first, bytes);
    std::memcpy(block.bytes, static_cast<const std::byte*>(from) + first, count);
    check(clEnqueueWriteBuffer(queue_(), memory, CL_FALSE, offset + first, count, block.bytes, 0,
                               nullptr, &block.copied),
          what);
    check(clFlush(queue_()), what);
  }
  for (Block& block : blocks_) wait_for(block);
}

void PinnedCopies::to_host(cl_mem memory, std::size_t offset, void* to, std::size_t bytes,
                           const std::function<void()>& checkpoint) {
  const std::string what = copying(bytes, "from");
  if (bytes <= kSmall)
    return check(
        clEnqueueReadBuffer(queue_(), memory, CL_TRUE, offset, bytes, to, 0, nullptr, nullptr),
        what);
  open();
  const auto fetch = [&](std::size_t first) {
    if (first >= bytes) return;
    Block& block = blocks_[first / kBlock % 2];
    wait_for(block);
    check(clEnqueueReadBuffer(queue_(), memory, CL_FALSE, offset + first, bytes_at(first, bytes),
                              block.bytes, 0, nullptr, &block.copied),
          what);
    check(clFlush(queue_()), what);
  };
  fetch(0);
  for (std::size_t first = 0; first < bytes; first += kBlock) {
    fetch(first + kBlock);
    Block& block = blocks_[first / kBlock % 2];
    wait_for(block);
    if (checkpoint) checkpoint();
    std::memcpy(static_cast<std::byte*>(to) + first, block.bytes, bytes_at(first, bytes));
  }
}

/// Has the blocks when it returns.
void PinnedCopies::open() {
  if (blocks_[0].bytes) return;
  const std::string what = "pinning " + std::to_string(2 * kBlock) + " bytes for " + device_;
  cl_int status = CL_SUCCESS;
  if (!pinned_) {
    pinned_ = clCreateBuffer(context_(), CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, 2 * kBlock,
                             nullptr, &status);
    check(status, what);
  }
  void* mapped = clEnqueueMapBuffer(queue_(), pinned_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0,
                                    2 * kBlock, 0, nullptr, nullptr, &status);
  check(status, what);
  blocks_[0].bytes = static_cast<std::byte*>(mapped);
  blocks_[1].bytes = blocks_[0].bytes + kBlock;
}

void PinnedCopies::wait_for(Block& block) {
  if (!block.copied) return;
  const cl_int status = clWaitForEvents(1, &block.copied);
  clReleaseEvent(std::exchange(block.copied, nullptr));
  check(status, "waiting for " + device_);
}

std::string PinnedCopies::copying(std::size_t bytes, const char* way) const {
  return "copying " + std::to_string(bytes) + " bytes " + way + " " + device_;
}

}  // namespace vasamesh

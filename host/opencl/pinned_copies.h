#pragma once

/// \file
/// Copies between the host's memory and a device's own through two blocks of pinned memory, which
/// the device reads and writes by itself: while it is at one, the host is at the other.

#include <array>
#include <cstddef>
#include <functional>
#include <string>

#include "opencl/check.h"

namespace vasamesh {

class PinnedCopies {
 public:
  PinnedCopies(cl::Context context, cl::CommandQueue queue, std::string device);
  ~PinnedCopies();
  PinnedCopies(const PinnedCopies&) = delete;
  PinnedCopies& operator=(const PinnedCopies&) = delete;

  /// Both return when the bytes have arrived, and call `checkpoint` between blocks; `offset` is the
  /// memory's. What is small goes straight. \pre no queued command uses the memory.
  /// \throws DeviceFailure
  void to_device(const void* from, std::size_t bytes, cl_mem memory, std::size_t offset,
                 const std::function<void()>& checkpoint);
  void to_host(cl_mem memory, std::size_t offset, void* to, std::size_t bytes,
               const std::function<void()>& checkpoint);

 private:
  struct Block {
    std::byte* bytes = nullptr;
    cl_event copied = nullptr;  ///< the end of the device's work on it; none: it is free
  };

  void open();
  void wait_for(Block& block);
  std::string copying(std::size_t bytes, const char* way) const;

  cl::Context context_;
  cl::CommandQueue queue_;
  std::string device_;
  cl_mem pinned_ = nullptr;  ///< both blocks, mapped for as long as it is there
  std::array<Block, 2> blocks_;
};

}  // namespace vasamesh

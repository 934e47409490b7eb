#pragma once

/// \file
/// Memory that the host and an OpenCL device share. On a device that works in the host's own memory
/// the host's allocation is the device's, and nothing is copied: a CPU sees it at any time; others
/// have it in turn with the host, which maps it, while both may read what neither writes. Elsewhere
/// each has its own, and the stale one is brought up to date when it is next looked at.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "opencl/backend.h"
#include "opencl/check.h"
#include "opencl/pinned_copies.h"

namespace vasamesh {

class DeviceMemory {
 public:
  /// \param copies  not by_device.
  DeviceMemory(cl::Context context, cl::CommandQueue queue, std::string device,
               DeviceCopies copies);
  ~DeviceMemory();
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  /// What to call while the device is waited for.
  void set_checkpoint(std::function<void()> checkpoint) { checkpoint_ = std::move(checkpoint); }

  /// Waits for all that is queued, with checkpoints; returns at once, on any thread, where nothing
  /// is. \throws DeviceFailure
  void wait();

  /// The address of new memory on the host, and as much on the device. \throws Error refused.
  void* allocate(std::size_t bytes);
  void release(void* handle) noexcept;

  /// Runs `queue`, which asks for the memory of one command by on_device() and queues it. What was
  /// lent to it comes back with what it has written, or is forgotten where it was not queued.
  template <class Queue>
  void command(const Queue& queue) {
    try {
      queue();
    } catch (...) {
      loans_.clear();
      throw;
    }
    idle_ = false;
    finish_loans();
  }

  /// The device's memory of an allocation, up to date, for a command that writes it or does not. An
  /// address that allocate() has not given is lent to the device until the command has ended.
  cl_mem on_device(void* handle, std::size_t bytes, bool writes);

  /// Brings the host's memory up to date, for the host to read, or to write.
  void bring_to_host(void* handle, bool writes);

  /// bring_to_host() of everything.
  void settle();

  void write(void* handle, std::size_t offset, const void* from, std::size_t bytes);
  void read(const void* handle, std::size_t offset, void* to, std::size_t bytes);

  /// Between the host's memory and the device's own, so far.
  std::int64_t copies() const { return copies_; }
  std::int64_t bytes_copied() const { return bytes_copied_; }

  /// Seconds in wait(), so far.
  double waited() const { return waited_; }

 private:
  /// What the host may do with an allocation; where it may read alone, so may the device, which
  /// otherwise waits for its turn.
  enum class HostMay { nothing, read, write };
  struct Allocation {
    cl_mem memory = nullptr;
    std::size_t bytes = 0;
    HostMay host = HostMay::read;  ///< of no meaning when shared
  };
  struct Loan {
    cl::Buffer memory;
    void* address;
    std::size_t bytes;
    bool writes;
  };

  void finish_loans();
  void give_back(void* handle, const Allocation& allocation);
  void give_back_left();
  bool is_shared() const { return where_ == DeviceCopies::shared; }
  bool is_mapped() const { return where_ == DeviceCopies::mapped; }
  bool is_separate() const { return where_ == DeviceCopies::separate; }
  cl_mem create(std::size_t bytes, void* host);
  cl_mem lend(void* address, std::size_t bytes, bool writes);
  void copy_in(cl_mem memory, std::size_t offset, const void* from, std::size_t bytes);
  void copy_out(cl_mem memory, std::size_t offset, void* to, std::size_t bytes);
  void count_copy(std::size_t bytes);
  void map(cl_mem memory, std::size_t bytes, HostMay what);
  cl_int unmap(cl_mem memory, void* host);
  void remap(HostMay what, void* handle, Allocation& own);
  void let_host(HostMay what, void* handle, Allocation& own);
  Allocation* find(const void* handle);

  cl::Context context_;
  cl::CommandQueue queue_;
  std::string device_;
  DeviceCopies where_;
  PinnedCopies pinned_;
  std::unordered_map<const void*, Allocation> allocations_;  // by the host's address
  std::vector<Loan> loans_;
  std::function<void()> checkpoint_;
  std::int64_t copies_ = 0, bytes_copied_ = 0;
  double waited_ = 0;
  bool idle_ = true;                                ///< nothing was queued since the last wait
  std::vector<std::pair<void*, Allocation>> left_;  ///< released while commands may use it
};

}  // namespace vasamesh

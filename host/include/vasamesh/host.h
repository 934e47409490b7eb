#pragma once

/// \file
/// What runs a conversion: devices, their choice, and the Context made of them.

#include <atomic>
#include <string>
#include <vector>

#include "vasamesh/pipeline.h"

namespace vasamesh {

/// One device that a backend can use.
struct DeviceInfo {
  int number = 0;         ///< as `vasamesh devices` numbers it, from 0
  int opencl_index = -1;  ///< in the order of OpenCL's loader, from 0; -1: not a device of its
  std::string backend;    ///< "tbb", "opencl"
  std::string type;       ///< "cpu", "gpu", "accelerator"
  std::string name;
  std::string driver;
  std::int64_t memory = 0;  ///< bytes, 0 where unknown
  int compute_units = 0;
  bool doubles = false;
};

/// Every device here; the oneTBB backend's CPU is always number 0.
std::vector<DeviceInfo> list_devices();

/// What make_context is asked for.
struct ContextOptions {
  std::string backend = "auto";  ///< "auto", "tbb" or "opencl"
  /// A number, a type (the first of it) or a part of one name; empty: what the environment variable
  /// VASAMESH_DEVICE says, which "tbb" ignores, else the first of the backend. With none named,
  /// "auto" is oneTBB, and beside it the first device other than the processor that beats it in
  /// some stage, for these; a device is tried once, which takes some seconds.
  std::string device;
  int threads = 0;             ///< of the oneTBB backend, four for each processor at most are
                               ///< started; 0: the machine's
  void* task_arena = nullptr;  ///< a tbb::task_arena of the caller's to run in; threads ignored
  /// As of the Context, which gets it: also stops the opening and the trial of a device.
  const std::atomic<bool>* cancel = nullptr;
};

/// Opens the devices. What first lists OpenCL's devices in a process, here or in list_devices(),
/// sets the environment variable POCL_CACHE_DIR for as long as it takes: no other thread may read
/// or change the environment meanwhile (docs/backends.md). With "opencl" the stages that have
/// kernels run on the OpenCL device, the others on oneTBB; the report names each, and says where a
/// device's arithmetic is such that it may give other bytes than the CPU; "auto" takes no such
/// device. \throws Error no_device, usage, cancelled.
Context make_context(const ContextOptions& options);

}  // namespace vasamesh

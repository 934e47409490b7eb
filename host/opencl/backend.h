#pragma once

/// \file
/// The OpenCL backend: the stages that have kernels (kernels/*.cl), on one OpenCL 1.2 device. It
/// gives the same bytes as the oneTBB backend on devices that divide and round as IEEE 754 says.

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/backend.h"
#include "opencl/work_shape.h"
#include "vasamesh/host.h"

namespace vasamesh {

constexpr std::uint32_t kAllStages = ~std::uint32_t{0};
constexpr std::uint32_t bit_of(Stage stage) { return 1u << static_cast<unsigned>(stage); }

/// How a kernel is cut into work-items. The arithmetic is the same for both.
enum class KernelShape {
  by_device,   ///< as tuned, else one_item on a CPU, work_group elsewhere
  one_item,    ///< one work-item takes a brick
  work_group,  ///< one work-group takes a brick, a work-item a row of 8 cells
};

/// Where a device's copy of a buffer lies.
enum class DeviceCopies {
  by_device,  ///< shared on a CPU, mapped on others that have the host's memory, else separate
  shared,     ///< in the host's memory, which both see at any time
  mapped,     ///< in the host's memory, which they have in turn, or both for reading
  separate,   ///< in memory of its own
};

struct OpenClOptions {
  int device = 0;  ///< an opencl_index of list_opencl_devices()
  KernelShape shape = KernelShape::by_device;
  std::optional<WorkShape> work_shape;  ///< instead of what `shape` says
  std::uint32_t stages = kAllStages;    ///< bit_of each Stage that it offers, of those with kernels
  DeviceCopies copies = DeviceCopies::by_device;
  /// Where built programs are kept; empty: $XDG_CACHE_HOME/vasamesh or ~/.cache/vasamesh, and
  /// nowhere on platforms that keep them themselves, as PoCL does (pocl.h). A folder that cannot be
  /// written costs a build each time, no error.
  std::string cache_folder;
  /// Runs the host's part of stages; null: the calling thread does.
  std::shared_ptr<Backend> workers;
  std::shared_ptr<ByteAccount> total;  ///< shared with other backends, or null
  /// Takes a device whose arithmetic is not the contract's, which Backend::other_arithmetic() then
  /// tells, for all stages but the proof.
  bool any_arithmetic = false;
  /// Asked while the device is opened, which may take its compiler some seconds; as of Context.
  const std::atomic<bool>* cancel = nullptr;
};

/// The OpenCL devices of all platforms that are ready and have a compiler, in the loader's order,
/// where devices that are not leave gaps of opencl_index and number. Empty where there is no
/// platform.
std::vector<DeviceInfo> list_opencl_devices();

/// What to do where that is empty, as "install a driver".
std::string opencl_remedy();

/// What a device gets that was not tuned.
WorkShape usual_opencl_shape(int device);

/// Opens a device. Its passes may be called from one thread at a time.
/// \throws Error no_device: no such device, it cannot be opened, or it does not compute as the
///         backend contract says and need not be taken all the same; cancelled.
std::shared_ptr<Backend> make_opencl_backend(const OpenClOptions& options);

}  // namespace vasamesh

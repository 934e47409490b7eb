#pragma once

/// \file
/// Kernels by name, built for one device: the files of kernels/ are one program, built when the
/// first kernel is asked for, from the cache on disk where it holds one.

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "opencl/check.h"
#include "opencl/kernel_sources.h"
#include "opencl/program_cache.h"
#include "opencl/work_shape.h"

namespace vasamesh {

class Programs {
 public:
  /// \param cache  as of cache_for().
  Programs(cl::Context context, cl::Device device, const WorkShape& shape,
           std::optional<ProgramCache> cache,
           std::span<const KernelSource> sources = kernel_sources());

  /// \throws DeviceFailure internal, with the build's log, when the files do not build; no_device
  /// where the device has no compiler.
  cl::Kernel& kernel(const std::string& name);

  /// What to call while a program is built.
  void set_checkpoint(std::function<void()> checkpoint) { checkpoint_ = std::move(checkpoint); }

 private:
  const cl::Program& program();
  std::string source() const;
  cl::Program from_cache(const std::string& key) const;
  cl::Program build(const std::string& source) const;
  cl_int build(const cl::Program& program) const;

  cl::Context context_;
  cl::Device device_;
  std::string options_;
  std::optional<ProgramCache> cache_;
  std::span<const KernelSource> sources_;
  std::function<void()> checkpoint_;
  cl::Program program_;                        // none until it is built
  std::map<std::string, cl::Kernel> kernels_;  // by name
};

/// Where a device's programs are kept, as of OpenClOptions; none on platforms that keep on disk
/// what they have built. (PoCL does, kernel by kernel as they are launched; asking it for a
/// program's binary makes it build each kernel once more.)
std::optional<ProgramCache> cache_for(const cl::Device& device, const std::string& folder);

/// Whether it is a device of PoCL's.
bool is_pocl(const cl::Device& device);

/// Whether the device is a processor, which shares the host's memory.
bool is_cpu(const cl::Device& device);

}  // namespace vasamesh

#pragma once

/// \file
/// Kernels by name, built for one device: a file of kernels/ is a program, built when the first of
/// its kernels is asked for, from the cache on disk where it holds one.

#include <functional>
#include <map>
#include <span>
#include <string>

#include "opencl/check.h"
#include "opencl/kernel_sources.h"
#include "opencl/program_cache.h"
#include "opencl/work_shape.h"

namespace vasamesh {

class Programs {
 public:
  Programs(cl::Context context, cl::Device device, const WorkShape& shape, ProgramCache cache,
           std::span<const KernelSource> sources = kernel_sources());

  /// The kernel of that name, from the file that defines it. \throws DeviceFailure internal, with
  /// the build's log, when the file does not build; no_device where the device has no compiler.
  cl::Kernel& kernel(const std::string& name);

  /// What to call while a program is built.
  void set_checkpoint(std::function<void()> checkpoint) { checkpoint_ = std::move(checkpoint); }

 private:
  std::string file_of(const std::string& kernel) const;
  const cl::Program& program(const std::string& file);
  std::string source_of(const std::string& file) const;
  cl::Program from_cache(const std::string& key) const;
  cl::Program build(const std::string& file, const std::string& source) const;
  cl_int build(const cl::Program& program) const;

  cl::Context context_;
  cl::Device device_;
  std::string options_;
  ProgramCache cache_;
  std::span<const KernelSource> sources_;
  std::function<void()> checkpoint_;
  std::map<std::string, cl::Program> programs_;  // by file
  std::map<std::string, cl::Kernel> kernels_;    // by name
};

}  // namespace vasamesh

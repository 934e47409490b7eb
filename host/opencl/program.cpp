#include "opencl/program.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "backend/device_failure.h"
#include "opencl/constants.h"
#include "opencl/wait.h"

namespace vasamesh {

namespace {

/// The one on whose CPU QUICK_BUILD (kernels/common.cl) has been tried: it is right there where no
/// kernel has a barrier.
bool is_pocl_3(const cl::Device& device) {
  const cl::Platform platform(ask<CL_DEVICE_PLATFORM>(device));
  return is_cpu(device) && ask<CL_PLATFORM_VERSION>(platform).find("PoCL 3.") != std::string::npos;
}

std::string options_of(const cl::Device& device, const WorkShape& shape) {
  std::string options = "-cl-std=CL1.2 -w";
  if (ask<CL_DEVICE_SINGLE_FP_CONFIG>(device) & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT)
    options += " -cl-fp32-correctly-rounded-divide-sqrt";
  const auto define = [&options](const char* name, int value) {
    options += std::string(" -D") + name + "=" + std::to_string(value);
  };
  define("BRICK_ITEMS", shape.brick_items);
  define("SCAN_ITEMS", shape.scan_items);
  define("SCAN_RUN", shape.scan_run);
  define("FOLD_ITEMS", shape.fold_items);
  define("REDUCE_ITEMS", shape.reduce_items);
  if (shape.brick_items == 1 && is_pocl_3(device)) define("QUICK_BUILD", 1);
  return options + kernel_constants();
}

/// What a built program depends on.
std::string key_of(const cl::Device& device, const std::string& options,
                   const std::string& source) {
  const cl::Platform platform(ask<CL_DEVICE_PLATFORM>(device));
  return ask<CL_PLATFORM_VERSION>(platform) + "\n" + ask<CL_DEVICE_NAME>(device) + "\n" +
         ask<CL_DEVICE_VERSION>(device) + "\n" + ask<CL_DRIVER_VERSION>(device) + "\n" + options +
         "\n" + source;
}

/// A log on one line, cut where it is long.
std::string one_line(std::string log) {
  std::replace(log.begin(), log.end(), '\n', ' ');
  std::erase(log, '\0');
  return log.size() > 2000 ? log.substr(0, 2000) + " ..." : log;
}

std::string binary_of(const cl::Program& program) {
  std::vector<std::vector<unsigned char>> binaries;
  if (program.getInfo(CL_PROGRAM_BINARIES, &binaries) != CL_SUCCESS || binaries.size() != 1)
    return {};
  return {binaries[0].begin(), binaries[0].end()};
}

}  // namespace

Programs::Programs(cl::Context context, cl::Device device, const WorkShape& shape,
                   std::optional<ProgramCache> cache, std::span<const KernelSource> sources)
    : context_(std::move(context)),
      device_(std::move(device)),
      options_(options_of(device_, shape)),
      cache_(std::move(cache)),
      sources_(sources) {}

cl::Kernel& Programs::kernel(const std::string& name) {
  if (const auto found = kernels_.find(name); found != kernels_.end()) return found->second;
  cl_int status = CL_SUCCESS;
  cl::Kernel kernel(program(), name.c_str(), &status);
  check(status, "taking kernel " + name);
  return kernels_.emplace(name, std::move(kernel)).first->second;
}

const cl::Program& Programs::program() {
  if (program_()) return program_;
  const std::string text = source();
  if (!cache_) return program_ = build(text);
  const std::string key = key_of(device_, options_, text);
  cl::Program program = from_cache(key);
  if (!program()) {
    program = build(text);
    if (const std::string binary = binary_of(program); !binary.empty()) cache_->store(key, binary);
  }
  return program_ = program;
}

/// common.cl, then the others, numbered as the log shall number their lines.
std::string Programs::source() const {
  std::string source;
  for (const bool common : {true, false})
    for (const KernelSource& part : sources_)
      if ((part.file == "common.cl") == common)
        source += "\n#line 1 \"" + std::string(part.file) + "\"\n" + std::string(part.text);
  return source;
}

/// An empty program where the cache has none that the driver accepts.
cl::Program Programs::from_cache(const std::string& key) const {
  const std::optional<std::string> binary = cache_->load(key);
  if (!binary) return {};
  cl_int status = CL_SUCCESS;
  cl::Program program(context_, {device_}, {{binary->begin(), binary->end()}}, nullptr, &status);
  if (status != CL_SUCCESS || build(program) != CL_SUCCESS) return {};
  return program;
}

cl_int Programs::build(const cl::Program& program) const {
  const auto work = [program, device = device_, options = options_] {
    return program.build(device, options.c_str());
  };
  return run_beside(work, checkpoint_);
}

cl::Program Programs::build(const std::string& source) const {
  cl_int status = CL_SUCCESS;
  cl::Program program(context_, source, false, &status);
  check(status, "making a program of the kernels");
  const cl_int built = build(program);
  if (built == CL_SUCCESS) return program;
  throw DeviceFailure(
      built == CL_COMPILER_NOT_AVAILABLE ? ErrorCode::no_device : ErrorCode::internal,
      "the kernels do not build for " + device_.getInfo<CL_DEVICE_NAME>() + ", " +
          status_name(built) + ", use --backend tbb; log: " +
          one_line(program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device_)));
}

std::optional<ProgramCache> cache_for(const cl::Device& device, const std::string& folder) {
  if (folder.empty() && is_pocl(device)) return std::nullopt;
  return ProgramCache(folder);
}

bool is_pocl(const cl::Device& device) {
  const cl::Platform platform(ask<CL_DEVICE_PLATFORM>(device));
  return ask<CL_PLATFORM_NAME>(platform).find("Portable Computing Language") != std::string::npos;
}

bool is_cpu(const cl::Device& device) {
  return (ask<CL_DEVICE_TYPE>(device) & CL_DEVICE_TYPE_CPU) != 0;
}

}  // namespace vasamesh

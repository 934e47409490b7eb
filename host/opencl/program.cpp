#include "opencl/program.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "backend/device_failure.h"
#include "opencl/constants.h"
#include "opencl/wait.h"

namespace vasamesh {

namespace {

std::string_view text_of(std::span<const KernelSource> sources, std::string_view file) {
  for (const KernelSource& source : sources)
    if (source.file == file) return source.text;
  throw Error(ErrorCode::internal, "no kernel file " + std::string(file) + " in this build");
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
                   ProgramCache cache, std::span<const KernelSource> sources)
    : context_(std::move(context)),
      device_(std::move(device)),
      options_(options_of(device_, shape)),
      cache_(std::move(cache)),
      sources_(sources) {}

cl::Kernel& Programs::kernel(const std::string& name) {
  if (const auto found = kernels_.find(name); found != kernels_.end()) return found->second;
  const std::string file = file_of(name);
  cl_int status = CL_SUCCESS;
  cl::Kernel kernel(program(file), name.c_str(), &status);
  check(status, "taking kernel " + name + " from " + file);
  return kernels_.emplace(name, std::move(kernel)).first->second;
}

std::string Programs::file_of(const std::string& kernel) const {
  const std::string definition = "void " + kernel + "(";
  for (const KernelSource& source : sources_)
    if (source.text.find(definition) != std::string_view::npos) return std::string(source.file);
  throw Error(ErrorCode::internal, "no kernel " + kernel + " in this build");
}

const cl::Program& Programs::program(const std::string& file) {
  if (const auto found = programs_.find(file); found != programs_.end()) return found->second;
  const std::string source = source_of(file);
  const std::string key = key_of(device_, options_, source);
  cl::Program program = from_cache(key);
  if (!program()) {
    program = build(file, source);
    if (const std::string binary = binary_of(program); !binary.empty()) cache_.store(key, binary);
  }
  return programs_.emplace(file, std::move(program)).first->second;
}

/// common.cl and the file, numbered as the log shall number their lines.
std::string Programs::source_of(const std::string& file) const {
  std::string source = "#line 1 \"common.cl\"\n";
  source += text_of(sources_, "common.cl");
  source += "\n#line 1 \"" + file + "\"\n";
  source += text_of(sources_, file);
  return source;
}

/// An empty program where the cache has none that the driver accepts.
cl::Program Programs::from_cache(const std::string& key) const {
  const std::optional<std::string> binary = cache_.load(key);
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

cl::Program Programs::build(const std::string& file, const std::string& source) const {
  cl_int status = CL_SUCCESS;
  cl::Program program(context_, source, false, &status);
  check(status, "making a program of " + file);
  const cl_int built = build(program);
  if (built == CL_SUCCESS) return program;
  throw DeviceFailure(
      built == CL_COMPILER_NOT_AVAILABLE ? ErrorCode::no_device : ErrorCode::internal,
      file + " does not build for " + device_.getInfo<CL_DEVICE_NAME>() + ", " +
          status_name(built) + ", use --backend tbb; log: " +
          one_line(program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device_)));
}

}  // namespace vasamesh

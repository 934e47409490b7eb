/// The OpenCL devices that are here.

#include <algorithm>

#include "backend/device_failure.h"
#include "opencl/opencl_backend.h"
#include "opencl/pocl.h"

namespace vasamesh {

namespace {

constexpr cl_ulong kLocalBytes = 16384;  // of any kernel's work-group

std::string type_of(cl_device_type type) {
  if (type & CL_DEVICE_TYPE_GPU) return "gpu";
  return type & CL_DEVICE_TYPE_CPU ? "cpu" : "accelerator";
}

DeviceInfo describe(const cl::Device& device, int index) {
  DeviceInfo info;
  info.number = index + 1;
  info.opencl_index = index;
  info.backend = "opencl";
  info.type = type_of(ask<CL_DEVICE_TYPE>(device));
  info.name = ask<CL_DEVICE_NAME>(device);
  info.driver = ask<CL_PLATFORM_NAME>(cl::Platform(ask<CL_DEVICE_PLATFORM>(device))) + " " +
                ask<CL_DRIVER_VERSION>(device);
  info.memory = static_cast<std::int64_t>(ask<CL_DEVICE_GLOBAL_MEM_SIZE>(device));
  info.compute_units = static_cast<int>(ask<CL_DEVICE_MAX_COMPUTE_UNITS>(device));
  info.doubles = ask<CL_DEVICE_DOUBLE_FP_CONFIG>(device) != 0;
  return info;
}

/// Whether kernels can be built for it. A driver that fails at a question may fail at any: then
/// the device does not count.
bool usable(const cl::Device& device) {
  return ask<CL_DEVICE_AVAILABLE>(device) && ask<CL_DEVICE_COMPILER_AVAILABLE>(device);
}

/// A loader without platforms, and a platform without devices, answer with a status: both are
/// "none" here.
std::vector<cl::Device> listed_devices() {
  std::vector<cl::Platform> platforms;
  if (cl::Platform::get(&platforms) != CL_SUCCESS) return {};
  std::vector<cl::Device> devices;
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> found;
    if (platform.getDevices(CL_DEVICE_TYPE_ALL, &found) != CL_SUCCESS) continue;
    devices.insert(devices.end(), found.begin(), found.end());
  }
  return devices;
}

}  // namespace

std::string lacks(const cl::Device& device, const WorkShape& shape) {
  const auto items = static_cast<std::size_t>(
      std::max({shape.brick_items, shape.scan_items, shape.fold_items, shape.reduce_items}));
  const auto most = [&](const char* what, auto has, auto needed) {
    return std::string("has ") + what + " of at most " + std::to_string(has) + ", not " +
           std::to_string(needed);
  };
  if (const auto largest = ask<CL_DEVICE_MAX_WORK_GROUP_SIZE>(device); largest < items)
    return most("work-groups", largest, items);
  if (const auto local = ask<CL_DEVICE_LOCAL_MEM_SIZE>(device); local < kLocalBytes)
    return most("bytes of local memory", local, kLocalBytes);
  if (!ask<CL_DEVICE_ENDIAN_LITTLE>(device)) return "is big-endian";
  if (ask<CL_DEVICE_PROFILE>(device) != "FULL_PROFILE") return "has no full profile of OpenCL";
  return is_pocl(device) ? pocl_lacks() : "";
}

void refuse_lacking(const cl::Device& device, const WorkShape& shape) {
  if (const std::string lack = lacks(device, shape); !lack.empty())
    throw DeviceFailure(ErrorCode::no_device, ask<CL_DEVICE_NAME>(device) + " " + lack +
                                                  ": choose another, or use --backend tbb");
}

std::vector<cl::Device> opencl_devices() {
  static const bool started = (start_pocl(listed_devices), true);
  static_cast<void>(started);
  return listed_devices();
}

std::string opencl_remedy() {
  if (const std::string& lack = pocl_lacks_folder(); !lack.empty()) return "PoCL " + lack;
  return "install a driver (pocl-opencl-icd runs on any CPU)";
}

std::vector<DeviceInfo> list_opencl_devices() {
  const std::vector<cl::Device> devices = opencl_devices();
  std::vector<DeviceInfo> list;
  for (std::size_t i = 0; i < devices.size(); ++i) try {
      if (usable(devices[i])) list.push_back(describe(devices[i], static_cast<int>(i)));
    } catch (const DeviceFailure&) {
    }
  return list;
}

}  // namespace vasamesh

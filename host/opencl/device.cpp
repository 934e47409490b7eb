/// The OpenCL devices that are here.

#include "opencl/opencl_backend.h"

namespace vasamesh {

namespace {

std::string type_of(const cl::Device& device) {
  const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
  if (type & CL_DEVICE_TYPE_GPU) return "gpu";
  return type & CL_DEVICE_TYPE_CPU ? "cpu" : "accelerator";
}

DeviceInfo describe(const cl::Device& device, int number) {
  DeviceInfo info;
  info.number = number;
  info.backend = "opencl";
  info.type = type_of(device);
  info.name = device.getInfo<CL_DEVICE_NAME>();
  const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
  info.driver = platform.getInfo<CL_PLATFORM_NAME>() + " " + device.getInfo<CL_DRIVER_VERSION>();
  info.memory = static_cast<std::int64_t>(device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>());
  info.compute_units = static_cast<int>(device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>());
  info.doubles = device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0;
  return info;
}

}  // namespace

/// A loader without platforms, and a platform without devices, answer with a status: both are
/// "none" here.
std::vector<cl::Device> opencl_devices() {
  std::vector<cl::Platform> platforms;
  if (cl::Platform::get(&platforms) != CL_SUCCESS) return {};
  std::vector<cl::Device> devices;
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> found;
    if (platform.getDevices(CL_DEVICE_TYPE_ALL, &found) != CL_SUCCESS) continue;
    for (const cl::Device& device : found)
      if (device.getInfo<CL_DEVICE_AVAILABLE>() && device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>())
        devices.push_back(device);
  }
  return devices;
}

std::vector<DeviceInfo> list_opencl_devices() {
  std::vector<DeviceInfo> list;
  for (const cl::Device& device : opencl_devices())
    list.push_back(describe(device, static_cast<int>(list.size())));
  return list;
}

}  // namespace vasamesh

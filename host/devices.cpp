/// Devices of all backends: their list, the choice of one, and the Context made of it.

#include <tbb/version.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "backend/backend.h"
#include "device_choice.h"
#include "opencl/backend.h"
#include "tbb/backend.h"
#include "tune.h"
#include "vasamesh/errors.h"
#include "vasamesh/host.h"

namespace vasamesh {

namespace {

constexpr char kDeviceVariable[] = "VASAMESH_DEVICE";

DeviceInfo describe_cpu() {
  DeviceInfo info;
  info.backend = "tbb";
  info.type = "cpu";
  info.name = processor_name();
  info.driver = std::string("oneTBB ") + TBB_runtime_version();
  info.memory = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
  info.compute_units = processor_count();
  info.doubles = true;
  return info;
}

/// The devices that the named backend may run on; "auto" may use all. OpenCL's runtimes, which take
/// a while to load, are asked only when one of theirs is meant.
std::vector<DeviceInfo> devices_of(const std::string& backend) {
  if (backend == "tbb") return {describe_cpu()};
  std::vector<DeviceInfo> devices = list_devices();
  if (backend != "auto")
    std::erase_if(devices, [&](const DeviceInfo& device) { return device.backend != backend; });
  if (devices.empty())
    throw Error(ErrorCode::no_device, "--backend " + backend + ": no such device here: " +
                                          opencl_remedy() + ", or use --backend tbb");
  return devices;
}

/// The variable is a default for those who leave the choice open.
DeviceInfo device_for(const ContextOptions& options) {
  const char* variable = std::getenv(kDeviceVariable);
  if (!options.device.empty())
    return choose_device(devices_of(options.backend), options.device, "--device");
  if (variable && *variable && options.backend != "tbb")
    return choose_device(devices_of(options.backend), variable, kDeviceVariable);
  return options.backend == "opencl" ? devices_of("opencl")[0] : describe_cpu();
}

/// Of a device beside oneTBB.
OpenClOptions opencl_options(const DeviceInfo& device, const std::shared_ptr<Backend>& host,
                             const std::shared_ptr<ByteAccount>& total,
                             const std::atomic<bool>* cancel) {
  OpenClOptions options;
  options.device = device.opencl_index;
  options.workers = host;
  options.total = total;
  options.cancel = cancel;
  return options;
}

bool device_named(const ContextOptions& options) {
  const char* variable = std::getenv(kDeviceVariable);
  return !options.device.empty() || (variable && *variable);
}

/// Whether the system has any device beside the processor: to ask OpenCL takes a while.
bool has_device_files() {
  std::error_code ignored;
  for (const char* path : {"/dev/dri", "/dev/nvidiactl", "/dev/kfd"})
    if (std::filesystem::exists(path, ignored)) return true;
  return false;
}

/// What `auto` adds to oneTBB: the first device beside the processor that beats it somewhere, for
/// the stages in which it does. (A processor's OpenCL shares what oneTBB already uses.) One that
/// fails is left out, and the reason kept.
void add_worthy(Context& context, const std::shared_ptr<Backend>& host,
                const std::shared_ptr<ByteAccount>& total) {
  if (!has_device_files()) return;
  for (const DeviceInfo& device : list_devices()) {
    if (device.type == "cpu") continue;
    try {
      const DeviceWorth worth = worth_of(device, host, context.cancel);
      if (worth.stages) {
        OpenClOptions options = opencl_options(device, host, total, context.cancel);
        options.stages = worth.stages;
        context.backends.push_back(make_opencl_backend(options));
        context.host_reason.clear();
        return;
      }
      context.host_reason = worth.reason;
    } catch (const Error& error) {
      if (error.code() == ErrorCode::cancelled) throw;
      context.host_reason = device.name + ": " + error.what();
    }
  }
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> devices{describe_cpu()};
  for (DeviceInfo& device : list_opencl_devices()) devices.push_back(std::move(device));
  return devices;
}

Context make_context(const ContextOptions& options) {
  if (options.backend != "auto" && options.backend != "tbb" && options.backend != "opencl")
    throw Error(ErrorCode::usage,
                "--backend " + options.backend + ": no such backend, use auto, tbb or opencl");
  if (options.threads < 0)
    throw Error(ErrorCode::usage, "--threads " + std::to_string(options.threads) +
                                      ": must be 0 (all of the machine's) or more");
  const DeviceInfo device = device_for(options);
  Context context;
  context.cancel = options.cancel;
  const auto total = std::make_shared<ByteAccount>();
  const auto host = make_tbb_backend(options.threads, options.task_arena, total);
  if (device.backend == "opencl") {
    OpenClOptions wanted = opencl_options(device, host, total, options.cancel);
    wanted.any_arithmetic = true;
    context.backends.push_back(make_opencl_backend(wanted));
  } else if (options.backend == "auto" && !device_named(options)) {
    add_worthy(context, host, total);
  }
  context.backends.push_back(host);
  return context;
}

}  // namespace vasamesh

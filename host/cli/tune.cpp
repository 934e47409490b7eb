/// \file
/// `vasamesh tune`: tries out devices and remembers what is fastest.

#include "tune.h"

#include <fmt/core.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "device_choice.h"
#include "vasamesh/errors.h"

namespace vasamesh::cli {

namespace {

#ifdef VASAMESH_WITH_OPENCL
void tune(const DeviceInfo& device, int threads) {
  fmt::print("{}: {}\n", device.number, device.name);
  const auto tell = [](const TuneTrial& trial) {
    fmt::print("  {:<40}{:>8.1f} ms{}\n", trial.shape, 1e3 * trial.seconds,
               trial.agrees ? "" : "  other bytes: not taken");
    std::fflush(stdout);
  };
  const TuneResult result = tune_device(device, threads, true, tell);
  fmt::print("  best: {}, {:.1f} ms; oneTBB {:.1f} ms; faster than that in: {}\n",
             result.best.shape, 1e3 * result.best.seconds, 1e3 * result.tbb_seconds,
             result.stages.empty() ? "nothing" : result.stages);
}
#else
void tune(const DeviceInfo&, int) {}
#endif

}  // namespace

void run_tune(const TuneRequest& request) {
  catch_interrupts(false);
  std::vector<DeviceInfo> devices = list_devices();
  std::erase_if(devices, [](const DeviceInfo& device) { return device.backend != "opencl"; });
  if (devices.empty())
    throw Error(ErrorCode::no_device,
                "no OpenCL device: install a driver (pocl-opencl-icd runs on any CPU)");
  if (!request.device.empty()) devices = {choose_device(devices, request.device, "--device")};
  for (const DeviceInfo& device : devices) tune(device, request.threads);
}

}  // namespace vasamesh::cli

/// \file
/// `vasamesh tune`: tries out devices and remembers what is fastest.

#include "tune.h"

#include <fmt/core.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "device_choice.h"
#include "opencl/backend.h"
#include "vasamesh/errors.h"

namespace vasamesh::cli {

namespace {

void tune(const DeviceInfo& device, int threads) {
  fmt::print("{}: {}\n", device.number, device.name);
  const auto tell = [](const TuneTrial& trial) {
    if (!trial.failure.empty())
      fmt::print("  {:<40}cannot run: {}\n", trial.shape, trial.failure);
    else
      fmt::print("  {:<40}{:>8.1f} ms{}\n", trial.shape, 1e3 * trial.seconds,
                 trial.agrees ? "" : "  another surface: not taken");
    std::fflush(stdout);
  };
  const TuneResult result = tune_device(device, threads, tell);
  fmt::print("  best: {}, {:.1f} ms; oneTBB {:.1f} ms; faster than that in: {}\n",
             result.best.shape, 1e3 * result.best.seconds, 1e3 * result.tbb_seconds,
             result.stages.empty() ? "nothing" : result.stages);
  if (!result.other_arithmetic.empty())
    fmt::print("  it {}: its surfaces are near oneTBB's, and --backend auto does not take it\n",
               result.other_arithmetic);
  if (!result.is_kept) fmt::print("  not remembered: the cache folder cannot be written\n");
}

}  // namespace

void run_tune(const TuneRequest& request) {
  catch_interrupts(false);
  std::vector<DeviceInfo> devices = list_devices();
  std::erase_if(devices, [](const DeviceInfo& device) { return device.backend != "opencl"; });
  if (devices.empty()) throw Error(ErrorCode::no_device, "no OpenCL device: " + opencl_remedy());
  if (!request.device.empty()) devices = {choose_device(devices, request.device, "--device")};
  bool any_tuned = false;
  for (const DeviceInfo& device : devices) {
    try {
      tune(device, request.threads);
    } catch (const Error& error) {
      if (&device == &devices.back() && !any_tuned) throw;
      fmt::print("  {}\n", error.what());
      continue;
    }
    any_tuned = true;
  }
}

}  // namespace vasamesh::cli

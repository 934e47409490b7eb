/// \file
/// `vasamesh devices`: what conversions can run on.

#include <fmt/core.h>

#include "cli/commands.h"

namespace vasamesh::cli {

void run_devices() {
  fmt::print("{:>2}  {:<8}{:<12}{:>6}{:>10}  {:<9}{}\n", "#", "backend", "type", "units", "memory",
             "doubles", "name, driver");
  for (const DeviceInfo& device : list_devices()) {
    const std::string memory =
        device.memory > 0
            ? fmt::format("{:.1f} GiB", static_cast<double>(device.memory) / (1 << 30))
            : "-";
    fmt::print("{:>2}  {:<8}{:<12}{:>6}{:>10}  {:<9}{}{}\n", device.number, device.backend,
               device.type, device.compute_units, memory, device.doubles ? "yes" : "no",
               device.name, device.driver.empty() ? "" : ", " + device.driver);
  }
}

}  // namespace vasamesh::cli

#include "device_choice.h"

#include <algorithm>
#include <iterator>

#include "lower_case.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

std::string describe(const std::vector<DeviceInfo>& devices) {
  std::string text;
  for (const DeviceInfo& device : devices)
    text += (text.empty() ? "" : ", ") + std::to_string(device.number) + " (" + device.backend +
            ", " + device.type + ", " + device.name + ")";
  return text.empty() ? "none" : text;
}

/// The devices whose number or type is `wanted`, or else whose name holds it, case ignored. Of one
/// type it is the first.
std::vector<DeviceInfo> matching(const std::vector<DeviceInfo>& devices,
                                 const std::string& wanted) {
  std::vector<DeviceInfo> found;
  for (const DeviceInfo& device : devices)
    if (std::to_string(device.number) == wanted || device.type == wanted) return {device};
  std::copy_if(devices.begin(), devices.end(), std::back_inserter(found),
               [&](const DeviceInfo& device) {
                 return lower_case(device.name).find(wanted) != std::string::npos;
               });
  return found;
}

}  // namespace

DeviceInfo choose_device(const std::vector<DeviceInfo>& devices, const std::string& wanted,
                         const std::string& asked_by) {
  const std::vector<DeviceInfo> found = matching(devices, lower_case(wanted));
  if (found.size() == 1) return found[0];
  throw Error(ErrorCode::no_device, asked_by + ": \"" + wanted + "\" fits " +
                                        (found.empty() ? "no device" : "several devices") +
                                        ": give the number or more of the name of one of " +
                                        describe(found.empty() ? devices : found));
}

}  // namespace vasamesh

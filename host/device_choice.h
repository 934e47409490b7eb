#pragma once

/// \file
/// Which device a word means.

#include <string>
#include <vector>

#include "vasamesh/host.h"

namespace vasamesh {

/// The one device that `wanted` means: its number, its type (the first of that type), or a part of
/// its name that no other's has, case ignored; tried in that order.
/// \param asked_by  the option or variable, for the message.
/// \throws Error no_device, naming the choices.
DeviceInfo choose_device(const std::vector<DeviceInfo>& devices, const std::string& wanted,
                         const std::string& asked_by);

}  // namespace vasamesh

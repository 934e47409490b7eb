#pragma once

/// \file
/// What a device's failure looks like above the backend contract.

#include "vasamesh/errors.h"

namespace vasamesh {

/// A device, its driver, its compiler or its memory failed, and what it was computing is lost. All
/// backends give a right surface, so that the work may be done again on another
/// (Scheduler::fall_back). The oneTBB backend never throws it.
class DeviceFailure : public Error {
 public:
  using Error::Error;
};

}  // namespace vasamesh

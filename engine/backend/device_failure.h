#pragma once

/// \file
/// What a device's failure looks like above the backend contract.

#include "vasamesh/errors.h"

namespace vasamesh {

/// A device, its driver, its compiler or its memory failed in a pass, which may have left anything
/// in the views that it writes. All backends give the same bytes, so that what was being computed
/// may be computed again on another (Scheduler::run_on).
class DeviceFailure : public Error {
 public:
  using Error::Error;
};

}  // namespace vasamesh

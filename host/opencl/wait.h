#pragma once

/// \file
/// Waiting for a device without losing sight of the caller.

#include <functional>
#include <string>

#include "opencl/check.h"

namespace vasamesh {

/// Waits until all that is queued is done, and calls `checkpoint` before and meanwhile, every few
/// milliseconds; what that throws leaves the commands running. \throws DeviceFailure
void wait_for(const cl::CommandQueue& queue, const std::function<void()>& checkpoint,
              const std::string& device);

/// work() on a thread of its own, with checkpoints meanwhile; what they throw leaves it running, so
/// that it must own what it uses. \return what it returns.
cl_int run_beside(std::function<cl_int()> work, const std::function<void()>& checkpoint);

}  // namespace vasamesh

#pragma once

/// \file
/// Whether a device computes as the backend contract says (engine/backend/backend.h): products
/// rounded before they are added, sub-normal numbers kept.

#include "opencl/check.h"
#include "opencl/program.h"

namespace vasamesh {

/// Asks the device for a few products and sums whose last bits tell.
bool arithmetic_as_specified(const cl::Context& context, const cl::CommandQueue& queue,
                             Programs& programs);

}  // namespace vasamesh

#pragma once

/// \file
/// Whether a device computes as the backend contract says (engine/backend/backend.h): products
/// rounded before they are added, sub-normal numbers kept, quotients and square roots rounded rightly.

#include "opencl/check.h"
#include "opencl/program.h"

namespace vasamesh {

/// Asks the device for products, sums, quotients and roots whose last bits tell.
bool arithmetic_as_specified(const cl::Context& context, const cl::CommandQueue& queue,
                             Programs& programs);

}  // namespace vasamesh

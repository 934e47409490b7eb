#pragma once

/// \file
/// Whether a device computes as the backend contract says (engine/backend/backend.h): products
/// rounded before they are added, sub-normal numbers kept, quotients and square roots rounded
/// rightly.

#include <string>

#include "opencl/check.h"
#include "opencl/program.h"

namespace vasamesh {

/// Asks the device for products, sums, quotients and roots whose last bits tell.
/// \return what it does otherwise, as "contracts products, drops sub-normal numbers"; else empty.
std::string other_arithmetic(const cl::Context& context, const cl::CommandQueue& queue,
                             Programs& programs);

}  // namespace vasamesh

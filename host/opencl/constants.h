#pragma once

/// \file
/// The engine's constants that kernels need, as the macros by which kernels/*.cl know them.

#include <string>

namespace vasamesh {

/// Options of the OpenCL C compiler, each with a space before it.
std::string kernel_constants();

}  // namespace vasamesh

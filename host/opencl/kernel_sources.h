#pragma once

/// \file
/// The text of kernels/*.cl, embedded by the build (cmake/embed_kernels.cmake).

#include <span>
#include <string_view>

namespace vasamesh {

struct KernelSource {
  std::string_view file;  ///< "poisson.cl"
  std::string_view text;
};

/// Every kernel file, common.cl among them.
std::span<const KernelSource> kernel_sources();

}  // namespace vasamesh

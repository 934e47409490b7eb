#pragma once

/// \file
/// What trials of a device have found (host/tune.h), kept beside the built programs: its fastest
/// shape, and what it is worth beside a processor with some threads, which `host` names. None where
/// device, driver or kernels have changed since.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "opencl/work_shape.h"

namespace vasamesh {

/// The shapes that are worth a trial on a device: an item a brick, or a group of 64 (kernels know
/// no others); for each, groups of 32 to 256 items over elements.
std::vector<WorkShape> shapes_to_try();

/// What a device is worth to `auto`.
struct DeviceWorth {
  std::uint32_t stages = 0;  ///< bit_of each in which it beats the processor
  std::string reason;        ///< why there are none: one line

  bool operator==(const DeviceWorth&) const = default;
};

/// \param device  an opencl_index. \param cache_folder  as of OpenClOptions.
/// \return of those that store: whether it could be kept.
/// \throws DeviceFailure where the device does not answer.
std::optional<WorkShape> load_shape(int device, const std::string& cache_folder);
bool store_shape(int device, const std::string& cache_folder, const WorkShape& shape);
std::optional<DeviceWorth> load_worth(int device, const std::string& cache_folder,
                                      const std::string& host);
bool store_worth(int device, const std::string& cache_folder, const std::string& host,
                 const DeviceWorth& worth);
void forget_worth(int device, const std::string& cache_folder, const std::string& host);

}  // namespace vasamesh

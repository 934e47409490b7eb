#pragma once

/// \file
/// How kernels are cut into work-items, and what was found best by trying.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "backend/backend.h"

namespace vasamesh {

/// Of one kind of device: macros of kernels/common.cl. The results are the same for all.
struct WorkShape {
  int brick_items, scan_items, scan_run, fold_items, reduce_items;

  int scan_block() const { return scan_items * scan_run; }
  bool operator==(const WorkShape&) const = default;
};
inline constexpr WorkShape kOneItemShape{1, 1, 16384, 64, 1};
inline constexpr WorkShape kWorkGroupShape{64, 128, 8, 64, 128};

/// The shapes that are worth a trial on a device: an item a brick, or a group of 64 (kernels know
/// no others); for each, groups of 32 to 256 items over elements.
std::vector<WorkShape> shapes_to_try();

constexpr std::uint32_t kAllStages = ~std::uint32_t{0};
constexpr std::uint32_t bit_of(Stage stage) { return 1u << static_cast<unsigned>(stage); }

/// What trials have found (host/tune.h): a device's fastest shape, and the stages, bit_of each, in
/// which it beat a processor with some threads, which `host` names. Kept beside the built programs;
/// none where device, driver or kernels have changed since.
/// \param device  of list_opencl_devices(). \param cache_folder  as of OpenClOptions.
/// \return of those that store: whether it could be kept.
/// \throws DeviceFailure where the device does not answer.
std::optional<WorkShape> load_shape(int device, const std::string& cache_folder);
bool store_shape(int device, const std::string& cache_folder, const WorkShape& shape);
std::optional<std::uint32_t> load_stages(int device, const std::string& cache_folder,
                                         const std::string& host);
bool store_stages(int device, const std::string& cache_folder, const std::string& host,
                  std::uint32_t stages);
void forget_stages(int device, const std::string& cache_folder, const std::string& host);

}  // namespace vasamesh

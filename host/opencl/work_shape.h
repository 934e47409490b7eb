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

/// What was found out about a device (host/tune.h).
struct Tuning {
  WorkShape shape = kWorkGroupShape;
  std::uint32_t stages = 0;             ///< bit_of each Stage in which the device beat oneTBB
  double seconds = 0, tbb_seconds = 0;  ///< of the trial's conversion on the device, and on oneTBB
};

constexpr std::uint32_t kAllStages = ~std::uint32_t{0};
constexpr std::uint32_t bit_of(Stage stage) { return 1u << static_cast<unsigned>(stage); }

/// Kept beside the built programs; none where device, driver or kernels have changed since.
/// \param device  of list_opencl_devices(). \param cache_folder  as of OpenClOptions.
/// \throws DeviceFailure where the device does not answer.
std::optional<Tuning> load_tuning(int device, const std::string& cache_folder);
void store_tuning(int device, const std::string& cache_folder, const Tuning& tuning);

}  // namespace vasamesh

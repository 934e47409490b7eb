#pragma once

/// \file
/// Trying out a device: which kernel shape is fastest, and in which stages it beats oneTBB. What is
/// found is remembered (host/opencl/work_shape.h) and used from then on: the shape whenever the
/// device is opened, the stages by `--backend auto`. Results never depend on it.

#include <cstdint>
#include <functional>
#include <string>

#include "vasamesh/host.h"

namespace vasamesh {

/// One conversion of the built-in volume.
struct TuneTrial {
  std::string shape;   ///< in words
  double seconds = 0;  ///< the best of three
  bool agrees = true;  ///< with oneTBB's surface; a shape that does not is not taken
};

struct TuneResult {
  TuneTrial best;
  double tbb_seconds = 0;
  std::string stages;  ///< names of those in which the device beat oneTBB; may be empty
};

/// \param device  an OpenCL device. \param search  all shapes; false: the device's usual one alone.
/// \param tell  called after each trial; may be empty.
/// \throws Error no_device, where the device cannot be opened or no shape agrees.
TuneResult tune_device(const DeviceInfo& device, int threads, bool search,
                       const std::function<void(const TuneTrial&)>& tell);

/// The stages in which a device beats oneTBB, as bit_of each; tried once, and remembered also where
/// it failed, until tune_device() finds otherwise. None where it fails.
std::uint32_t stages_worth(const DeviceInfo& device, int threads);

}  // namespace vasamesh

#pragma once

/// \file
/// Trying out a device: which kernel shape is fastest, and in which stages it beats oneTBB. What is
/// found is remembered (host/opencl/tuning.h) and used from then on: the shape whenever the
/// device is opened, the stages by `--backend auto`. Results never depend on it, but for the last
/// bits of a device of other arithmetic.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "backend/backend.h"
#include "opencl/tuning.h"
#include "vasamesh/host.h"

namespace vasamesh {

/// Conversions of the built-in volume in one shape.
struct TuneTrial {
  std::string shape;    ///< in words
  double seconds = 0;   ///< the best of three
  bool agrees = false;  ///< with oneTBB's surface: its bytes or, of a device of other arithmetic,
                        ///< near it; a shape that does not is not taken
  std::string failure;  ///< why the device could not run it; empty where it could
};

struct TuneResult {
  TuneTrial best;
  double tbb_seconds = 0;
  std::string stages;            ///< names of those in which the device beat oneTBB; may be empty
  std::string other_arithmetic;  ///< of the device, as of Backend; `auto` takes none that has one
  bool is_kept = true;           ///< false where the cache folder cannot be written
};

/// Tries all shapes on an OpenCL device, beside oneTBB on so many threads.
/// \param tell  called after each trial; may be empty.
/// \throws Error no_device, where the device cannot be opened or no shape agrees.
TuneResult tune_device(const DeviceInfo& device, int threads,
                       const std::function<void(const TuneTrial&)>& tell);

/// What a device is worth to `auto`: found by a trial beside the oneTBB backend `host`, and
/// remembered also where that failed, until tune_device() finds otherwise. Without a trial where
/// nothing can be remembered: it would be tried each time.
/// \param cancel  as of Context. \throws Error cancelled.
DeviceWorth worth_of(const DeviceInfo& device, const std::shared_ptr<Backend>& host,
                     const std::atomic<bool>* cancel);

}  // namespace vasamesh

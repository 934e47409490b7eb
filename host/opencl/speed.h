#pragma once

/// \file
/// What an OpenCL device can do at best, as measure/machine.h has it of the processor.

namespace vasamesh {

/// Bytes a second of a triad, and float32 additions and multiplications a second without fma.
struct DeviceSpeed {
  double bandwidth = 0, arithmetic = 0;
};

/// Measured, in some tenths of a second, by the clock. \param device  an opencl_index.
/// \throws DeviceFailure
DeviceSpeed measure_opencl_speed(int device);

}  // namespace vasamesh

#pragma once

/// \file
/// Conversions measured stage by stage, on several backends and numbers of threads.

#include <cstdint>
#include <string>
#include <vector>

#include "measure/work.h"
#include "vasamesh/host.h"
#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// What a backend could do at best: bytes a second of a triad over memory, and float32 additions
/// and multiplications a second.
struct Speed {
  double bandwidth = 0, arithmetic = 0;
};

/// One way to run a conversion.
struct BenchWay {
  ContextOptions context;  ///< backend "tbb" or "opencl", a device, threads
  std::string name;        ///< "tbb 2", "opencl"
  std::string device;
  Speed speed;
};

/// The ways that are asked for, their speeds measured.
/// \param backends  "tbb", "opencl"; empty: all that are here.
/// \param threads  of oneTBB; empty: 1, 2, 4 and so on up to the machine's.
/// \throws Error no_device, usage.
std::vector<BenchWay> bench_ways(const std::vector<std::string>& backends,
                                 const std::string& device, const std::vector<int>& threads);

struct BenchStage {
  std::string name, backend;
  double seconds = 0;  ///< median of the repeats
  Work work;           ///< that the stage must do at least
  std::int64_t launches = 0, copies = 0, bytes_copied = 0;
  bool agrees = true;  ///< with the first way's result of that stage
};

/// One input on one way.
struct BenchRun {
  std::vector<BenchStage> stages;
  double seconds = 0;            ///< of all stages: the median of the repeats
  double longest_silence = 0;    ///< seconds between two calls of Context::progress
  std::int64_t bytes_peak = 0;   ///< held by the backends' buffers
  std::string failure;           ///< of the device; empty when it did not fail
  std::string other_arithmetic;  ///< of the device, as of Backend
  /// Largest and mean distance from the first way's surface, voxels, where that has other bytes.
  double largest_distance = 0, mean_distance = 0;
};

struct BenchTable {
  std::int64_t voxels = 0, object_voxels = 0, points = 0, triangles = 0;
  std::vector<BenchRun> runs;  ///< one a way
};

/// Converts the volume once to warm up and `repeat` times to measure, on each way in turn.
/// \throws Error as convert() does.
BenchTable bench(const VolumeView& volume, const Parameters& parameters,
                 const std::vector<BenchWay>& ways, int repeat);

}  // namespace vasamesh

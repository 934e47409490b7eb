#include "measure/bench.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "backend/backend.h"
#include "device_choice.h"
#include "measure/machine.h"
#include "median.h"
#include "opencl/speed.h"
#include "stages/distance.h"
#include "stages/points.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<int> usual_threads() {
  std::vector<int> threads;
  const int most = processor_count();
  for (int n = 1; n < most; n *= 2) threads.push_back(n);
  threads.push_back(most);
  return threads;
}

BenchWay tbb_way(const DeviceInfo& cpu, int threads) {
  BenchWay way;
  way.context.backend = "tbb";
  way.context.threads = threads;
  way.name = "tbb " + std::to_string(threads);
  way.device = cpu.name;
  const int at_once = std::clamp(threads, 1, processor_count());
  way.speed = {measure_bandwidth(at_once), measure_arithmetic(at_once)};
  return way;
}

BenchWay opencl_way(const DeviceInfo& device) {
  BenchWay way;
  way.context.backend = "opencl";
  way.context.device = std::to_string(device.number);
  way.name = "opencl " + way.context.device;
  way.device = device.name;
  const DeviceSpeed speed = measure_opencl_speed(device.opencl_index);
  way.speed = {speed.bandwidth, speed.arithmetic};
  return way;
}

/// 64 bits of FNV-1a over numbers: equal results have equal digests.
class Digest {
 public:
  template <class T>
  Digest& operator()(const T* values, std::size_t count) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values);
    for (std::size_t i = 0; i < count * sizeof(T); ++i) {
      value_ ^= bytes[i];
      value_ *= 0x100000001b3u;
    }
    return *this;
  }
  template <class T>
  Digest& operator()(const T& value) {
    return (*this)(&value, 1);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// What each stage has come to, as far as the result tells: counts, residuals, the surface itself,
/// which also stands for the stages that are not named.
std::map<std::string, std::uint64_t> digests(const Result& result) {
  const Report& report = result.report;
  Digest input, points, octree, poisson, topology, surface, quality;
  input(report.input.object_voxels)(report.input.handles.count)(report.input.cavities.count);
  points(report.points)(report.thin_points);
  for (const LevelReport& level : report.levels) {
    octree(level.nodes)(level.leaves);
    poisson(level.iterations)(level.initial_residual)(level.residual);
  }
  const RelabelReport& relabel = report.relabel;
  topology(relabel.lattice_nodes)(relabel.flips)(relabel.stuck_first)(relabel.clamped);
  surface(result.mesh.vertices.data(), result.mesh.vertices.size());
  surface(result.mesh.triangles.data(), result.mesh.triangles.size());
  quality(report.quality.edge_ratio.mean)(report.quality.area)(report.quality.volume);
  return {{"input", input.value()},       {"points", points.value()},
          {"octree", octree.value()},     {"poisson", poisson.value()},
          {"topology", topology.value()}, {"surface", surface.value()},
          {"check", surface.value()},     {"quality", quality.value()}};
}

/// One way's conversions of one volume.
class Runner {
 public:
  Runner(const VolumeView& volume, const Parameters& parameters, const BenchWay& way)
      : volume_(volume), parameters_(parameters), context_(make_context(way.context)) {
    context_.progress = [this](std::string_view, double) {
      run_.longest_silence = std::max(run_.longest_silence, seconds_since(told_));
      told_ = Clock::now();
      return true;
    };
  }

  Result convert_once() {
    told_ = Clock::now();
    return vasamesh::convert(volume_, parameters_, context_);
  }

  /// After it has warmed up.
  Result measure(int repeat) {
    run_.longest_silence = 0;
    Result result;
    std::vector<std::vector<StageReport>> repeats;
    for (int i = 0; i < repeat; ++i) {
      result = convert_once();
      repeats.push_back(result.report.stages);
    }
    gather(repeats, result.report);
    run_.other_arithmetic = context_.backends.front()->other_arithmetic();
    for (const auto& backend : context_.backends)
      run_.bytes_peak += static_cast<std::int64_t>(backend->bytes_peak());
    return result;
  }
  const BenchRun& run() const { return run_; }

  void compare(const TriangleMesh& mesh, const TriangleMesh& first) {
    if (mesh == first) return;
    const double voxel = voxel_length(volume_.geometry);
    const DistanceReport distance = measure_distance(*context_.backends.back(), mesh, first, voxel);
    run_.largest_distance = std::max(distance.to.maximum, distance.back.maximum) / voxel;
    run_.mean_distance = std::max(distance.to.mean, distance.back.mean) / voxel;
  }

 private:
  /// Stages of one name count as one.
  void gather(const std::vector<std::vector<StageReport>>& repeats, const Report& report) {
    std::map<std::string, std::vector<double>> seconds;
    std::vector<double> totals;
    for (const auto& stages : repeats) {
      std::map<std::string, double> sums;
      double total = 0;
      for (const StageReport& stage : stages) {
        sums[stage.name] += stage.seconds;
        total += stage.seconds;
      }
      for (const auto& [name, sum] : sums) seconds[name].push_back(sum);
      totals.push_back(total);
    }
    run_.seconds = median(totals);
    for (const StageReport& stage : repeats.back()) {
      if (!stage.failure.empty()) run_.failure = stage.failure;
      BenchStage& row = row_of(stage.name);
      row.backend = stage.backend;
      row.seconds = median(seconds[stage.name]);
      row.work = stage_work(stage.name, report);
      row.launches += stage.launches;
      row.copies += stage.copies;
      row.bytes_copied += stage.bytes_copied;
    }
  }

  BenchStage& row_of(const std::string& name) {
    for (BenchStage& row : run_.stages)
      if (row.name == name) return row;
    run_.stages.emplace_back().name = name;
    return run_.stages.back();
  }

  const VolumeView& volume_;
  const Parameters& parameters_;
  Context context_;
  BenchRun run_;
  Clock::time_point told_;
};

}  // namespace

std::vector<BenchWay> bench_ways(const std::vector<std::string>& backends,
                                 const std::string& device, const std::vector<int>& threads) {
  const auto asked = [&](const char* backend) {
    return backends.empty() || std::count(backends.begin(), backends.end(), backend) > 0;
  };
  const std::vector<DeviceInfo> devices = list_devices();
  std::vector<BenchWay> ways;
  if (asked("tbb"))
    for (const int n : threads.empty() ? usual_threads() : threads)
      ways.push_back(tbb_way(devices[0], capped_threads(n)));
  if (!asked("opencl")) return ways;
  std::vector<DeviceInfo> on;
  std::copy_if(devices.begin(), devices.end(), std::back_inserter(on),
               [](const DeviceInfo& info) { return info.backend == "opencl"; });
  if (on.empty() && !backends.empty())
    throw Error(ErrorCode::no_device,
                "--backends opencl: no such device here: see vasamesh devices");
  if (!device.empty()) on = {choose_device(on, device, "--device")};
  for (const DeviceInfo& info : on) ways.push_back(opencl_way(info));
  return ways;
}

BenchTable bench(const VolumeView& volume, const Parameters& parameters,
                 const std::vector<BenchWay>& ways, int repeat) {
  int most = processor_count();
  for (const BenchWay& way : ways) most = std::max(most, way.context.threads);
  const tbb::global_control as_many(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(most));
  BenchTable table;
  TriangleMesh first;
  std::map<std::string, std::uint64_t> wanted;
  for (const BenchWay& way : ways) {
    Runner runner(volume, parameters, way);
    runner.convert_once();
    Result result = runner.measure(repeat);
    table.object_voxels = result.report.input.object_voxels;
    table.points = result.report.points;
    table.triangles = static_cast<std::int64_t>(result.mesh.triangle_count());
    const auto got = digests(result);
    if (wanted.empty()) {
      wanted = got;
      first = std::move(result.mesh);
    } else {
      runner.compare(result.mesh, first);
    }
    BenchRun& run = table.runs.emplace_back(runner.run());
    for (BenchStage& stage : run.stages) {
      const std::string name = got.contains(stage.name) ? stage.name : "surface";
      stage.agrees = got.at(name) == wanted.at(name);
    }
  }
  table.voxels = volume.geometry.size[0] * volume.geometry.size[1] * volume.geometry.size[2];
  return table;
}

}  // namespace vasamesh

/// \file
/// `vasamesh bench`: conversions measured stage by stage on each backend.

#include "measure/bench.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/volume_errors.h"
#include "io/report_json.h"
#include "io/volume_reader.h"

namespace vasamesh::cli {

namespace {

using Json = nlohmann::ordered_json;

double percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

/// Seconds of the same stage, or of all, on one oneTBB thread, where that was measured; else 0.
double one_thread_seconds(const std::vector<BenchWay>& ways, const BenchTable& table,
                          const std::string& stage) {
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (ways[i].name != "tbb 1") continue;
    if (stage == "all") return table.runs[i].seconds;
    for (const BenchStage& row : table.runs[i].stages)
      if (row.name == stage) return row.seconds;
  }
  return 0;
}

std::string or_dash(double value, const char* format) {
  return value > 0 ? fmt::format(fmt::runtime(format), value) : "-";
}

void print_stage(const BenchWay& way, const BenchRun& run, const BenchStage& stage,
                 double one_thread) {
  const double per_second = 1 / std::max(stage.seconds, 1e-9);
  fmt::print("  {:<10}{:<8}{:>9.1f}{:>7.1f}{:>9}{:>8}{:>9}{:>8}{:>8}{:>9}{:>10}  {}\n", stage.name,
             stage.backend, 1e3 * stage.seconds, percent(stage.seconds, run.seconds),
             or_dash(stage.work.bytes * 1e-6, "{:.0f}"),
             or_dash(percent(stage.work.bytes * per_second, way.speed.bandwidth), "{:.1f}"),
             or_dash(stage.work.operations * 1e-6, "{:.0f}"),
             or_dash(percent(stage.work.operations * per_second, way.speed.arithmetic), "{:.1f}"),
             or_dash(one_thread * per_second, "{:.2f}"),
             or_dash(static_cast<double>(stage.launches), "{:.0f}"),
             or_dash(static_cast<double>(stage.bytes_copied) * 1e-6, "{:.1f}"),
             stage.agrees ? "yes" : "NO");
}

void print_run(const std::vector<BenchWay>& ways, const BenchTable& table, std::size_t index) {
  const BenchWay& way = ways[index];
  const BenchRun& run = table.runs[index];
  fmt::print("\n{}: {}; {:.1f} GB/s, {:.0f} G operations/s\n", way.name, way.device,
             way.speed.bandwidth * 1e-9, way.speed.arithmetic * 1e-9);
  fmt::print("  {:<10}{:<8}{:>9}{:>7}{:>9}{:>8}{:>9}{:>8}{:>8}{:>9}{:>10}  {}\n", "stage", "on",
             "ms", "%", "MB", "% bandw", "M ops", "% peak", "x tbb 1", "launches", "MB copied",
             "agrees");
  for (const BenchStage& stage : run.stages)
    print_stage(way, run, stage, one_thread_seconds(ways, table, stage.name));
  const double one = one_thread_seconds(ways, table, "all");
  fmt::print(
      "  {:<18}{:>9.1f}  {} times tbb 1; buffers {:.0f} MB at most; cancelled within {:.0f} ms\n",
      "all", 1e3 * run.seconds, or_dash(one / run.seconds, "{:.2f}"),
      static_cast<double>(run.bytes_peak) * 1e-6, 1e3 * run.longest_silence);
  if (!run.other_arithmetic.empty()) fmt::print("  the device {}\n", run.other_arithmetic);
  if (run.largest_distance > 0)
    fmt::print("  the surface is {:.3f} voxel from that of {} at most, {:.4f} on average\n",
               run.largest_distance, ways.front().name, run.mean_distance);
  if (!run.failure.empty()) fmt::print("  the device failed: {}\n", run.failure);
}

Json to_json(const BenchStage& stage) {
  return {{"name", stage.name},
          {"backend", stage.backend},
          {"seconds", stage.seconds},
          {"bytes", stage.work.bytes},
          {"operations", stage.work.operations},
          {"launches", stage.launches},
          {"copies", stage.copies},
          {"bytes_copied", stage.bytes_copied},
          {"agrees", stage.agrees}};
}

Json to_json(const BenchWay& way, const BenchRun& run) {
  Json out{{"name", way.name},
           {"device", way.device},
           {"bandwidth", way.speed.bandwidth},
           {"arithmetic", way.speed.arithmetic},
           {"seconds", run.seconds},
           {"longest_silence", run.longest_silence},
           {"bytes_peak", run.bytes_peak},
           {"failure", run.failure},
           {"other_arithmetic", run.other_arithmetic},
           {"largest_distance", run.largest_distance},
           {"mean_distance", run.mean_distance}};
  for (const BenchStage& stage : run.stages) out["stages"].push_back(to_json(stage));
  return out;
}

Json to_json(const std::string& input, const std::vector<BenchWay>& ways, const BenchTable& table) {
  Json out{{"input", input},
           {"voxels", table.voxels},
           {"object_voxels", table.object_voxels},
           {"points", table.points},
           {"triangles", table.triangles}};
  for (std::size_t i = 0; i < ways.size(); ++i)
    out["runs"].push_back(to_json(ways[i], table.runs[i]));
  return out;
}

}  // namespace

void run_bench(const BenchRequest& request) {
  catch_interrupts(false);
  validate(request.parameters);
  const std::vector<BenchWay> ways = bench_ways(request.backends, request.device, request.threads);
  Json all = Json::array();
  for (const std::string& input : request.inputs) {
    const Segmentation volume = read_segmentation(input, request.read);
    const BenchTable table = on_volume_of(
        input, [&] { return bench(volume.view(), request.parameters, ways, request.repeat); });
    if (request.json) {
      all.push_back(to_json(input, ways, table));
      continue;
    }
    fmt::print("{}: {} voxels, {} in the object, {} points, {} triangles\n", input, table.voxels,
               table.object_voxels, table.points, table.triangles);
    for (std::size_t i = 0; i < ways.size(); ++i) print_run(ways, table, i);
  }
  if (request.json) fmt::print("{}\n", to_text(all));
}

}  // namespace vasamesh::cli

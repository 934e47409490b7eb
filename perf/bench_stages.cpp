/// \file
/// Each stage of a conversion of the cerebral phantom, on one and two threads. `bytes_per_second`
/// and `operations` are those of the stage's floor over its time; `floor_ms` is the time that
/// the floor takes at the machine's own bandwidth or arithmetic, the larger of the two.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "conversion.h"
#include "measure/machine.h"

namespace vasamesh {
namespace {

constexpr int kThreads[] = {1, 2};

struct Machine {
  double bandwidth, arithmetic;
};

const Machine& machine(int threads) {
  static const Machine measured[] = {{measure_bandwidth(1), measure_arithmetic(1)},
                                     {measure_bandwidth(2), measure_arithmetic(2)}};
  return measured[threads - 1];
}

const Phantom& cerebral() {
  static const Phantom phantom = make_phantom("cerebral");
  return phantom;
}

void run_stage(benchmark::State& state, std::size_t index, int threads) {
  Conversion conversion(cerebral(), threads);
  for (std::size_t i = 0; i <= index; ++i) (conversion.*kConversionStages[i].run)();
  const ConversionStage& stage = kConversionStages[index];
  for (auto _ : state) {
    if (stage.restore) {
      state.PauseTiming();
      (conversion.*stage.restore)();
      state.ResumeTiming();
    }
    (conversion.*stage.run)();
  }
  const Work floor = (conversion.*stage.floor)();
  const Machine& limits = machine(threads);
  const double seconds =
      std::max(floor.bytes / limits.bandwidth, floor.operations / limits.arithmetic);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(floor.bytes));
  state.counters["floor_MB"] = floor.bytes * 1e-6;
  state.counters["floor_Mop"] = floor.operations * 1e-6;
  state.counters["floor_ms"] = 1e3 * seconds;
}

void register_stages() {
  for (std::size_t index = 0; index < std::size(kConversionStages); ++index)
    for (const int threads : kThreads)
      benchmark::RegisterBenchmark(
          (std::string(kConversionStages[index].name) + "/threads:" + std::to_string(threads))
              .c_str(),
          [index, threads](benchmark::State& state) { run_stage(state, index, threads); })
          ->MeasureProcessCPUTime()
          ->UseRealTime()
          ->MinTime(0.3)
          ->Unit(benchmark::kMillisecond);
}

void describe_machine() {
  for (const int threads : kThreads) {
    const std::string suffix = std::to_string(threads) + "_threads";
    benchmark::AddCustomContext("bandwidth_GBps_" + suffix,
                                std::to_string(machine(threads).bandwidth * 1e-9));
    benchmark::AddCustomContext("arithmetic_Gops_" + suffix,
                                std::to_string(machine(threads).arithmetic * 1e-9));
  }
}

}  // namespace
}  // namespace vasamesh

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  vasamesh::describe_machine();
  vasamesh::register_stages();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

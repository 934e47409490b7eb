/// The conjugate gradient's passes on every backend, over bricks round a sphere. bytes_per_second
/// counts what a pass must move: each array once, no cache misses twice.

#include <benchmark/benchmark.h>

#include "stages/bricks.h"
#include "support/backends.h"
#include "support/brick_sets.h"
#include "types/octree.h"

namespace vasamesh {
namespace {

constexpr int kShellRadius = 12;  // bricks; about 4,000 of them
constexpr int kQueued = 8;        // passes before one waits for a value

/// Arrays of one level on a backend.
struct Level {
  explicit Level(Backend& on)
      : backend(on),
        bricks(make_bricks(on, shell_bricks(kShellRadius))),
        unknown(to_backend(on, std::vector<std::uint8_t>(cells(), 1))),
        p(to_backend(on, random_floats(cells(), 2))),
        b(to_backend(on, random_floats(cells(), 3))),
        x(to_backend(on, random_floats(cells(), 4))),
        r(to_backend(on, random_floats(cells(), 5))),
        partial(to_backend(on, std::vector<float>(bricks.count, 0.0f))),
        partial_b(to_backend(on, std::vector<float>(bricks.count, 0.0f))) {}

  std::size_t cells() const { return bricks.count * kBrickCells; }
  LevelView view() const { return {0, bricks.view(), {1.25f, 0.8f, 0.61f}}; }
  float sum() { return backend.reduce_sum(partial.view()); }

  void residual() {
    backend.poisson_residual(view(), unknown.view(), b.view(), x.view(), r.view(), p.view(),
                             partial_b.view(), partial.view());
  }
  void energy() { backend.poisson_energy(view(), unknown.view(), p.view(), partial.view()); }
  void update_solution() {
    backend.poisson_update_solution(view(), unknown.view(), 1e-6f, p.view(), x.view(), r.view(),
                                    partial.view());
  }
  void update_direction() { backend.poisson_update_direction(view(), 0.5f, r.view(), p.view()); }

  Backend& backend;
  Bricks bricks;
  Buffer<std::uint8_t> unknown;
  Buffer<float> p, b, x, r, partial, partial_b;
};

/// One pass, and the bytes a cell of it moves.
struct Pass {
  const char* name;
  void (Level::*run)();
  int bytes_per_cell;
};
constexpr Pass kPasses[] = {{"poisson_residual", &Level::residual, 17},
                            {"poisson_energy", &Level::energy, 5},
                            {"poisson_update_solution", &Level::update_solution, 21},
                            {"poisson_update_direction", &Level::update_direction, 12}};

void report(benchmark::State& state, const Level& level, int passes, int bytes_per_cell) {
  state.SetLabel(level.backend.device());
  state.counters["bricks"] = static_cast<double>(level.bricks.count);
  state.SetBytesProcessed(state.iterations() * passes * bytes_per_cell *
                          static_cast<std::int64_t>(level.cells()));
}

/// Eight passes and a value read back.
void run_pass(benchmark::State& state, Backend& backend, const Pass& pass) {
  Level level(backend);
  (level.*pass.run)();
  level.sum();
  for (auto _ : state) {
    for (int i = 0; i < kQueued; ++i) (level.*pass.run)();
    benchmark::DoNotOptimize(level.sum());
  }
  report(state, level, kQueued, pass.bytes_per_cell);
}

/// One iteration of the conjugate gradient: three passes and two sums.
void run_iteration(benchmark::State& state, Backend& backend) {
  Level level(backend);
  level.energy();
  level.sum();
  for (auto _ : state) {
    level.energy();
    benchmark::DoNotOptimize(level.sum());
    level.update_solution();
    benchmark::DoNotOptimize(level.sum());
    level.update_direction();
  }
  report(state, level, 1, 5 + 21 + 12);
}

void register_backend(const std::string& name, std::shared_ptr<Backend> backend) {
  for (const Pass& pass : kPasses)
    benchmark::RegisterBenchmark(
        (std::string(pass.name) + "_x8/" + name).c_str(),
        [backend, pass](benchmark::State& state) { run_pass(state, *backend, pass); })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark(
      ("poisson_iteration/" + name).c_str(),
      [backend](benchmark::State& state) { run_iteration(state, *backend); })
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace vasamesh

int main(int argc, char** argv) {
  for (const std::string& name : vasamesh::backend_names())
    if (auto backend = vasamesh::open_backend(name)) vasamesh::register_backend(name, backend);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

/// \file
/// Gap stitching: the dynamic programming on one gap of n corners, and thousands of small gaps at
/// once.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "stages/stitch.h"
#include "support/analytic_field.h"
#include "support/shapes.h"
#include "tbb/backend.h"

namespace vasamesh::test {
namespace {

/// Corners about one length apart round a disc in the plane, rough.
struct DiscGap {
  explicit DiscGap(int corners) : field(plane_field(64, 32)) {
    std::mt19937 random(4);
    const auto uniform = [&] { return random() * 0x1p-31 - 1; };
    const double radius = corners / (2 * std::numbers::pi);
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.1 * uniform()) / corners;
      const double r = radius * (1 + 0.15 * uniform());
      points.push_back({static_cast<float>(32 + r * std::cos(angle)),
                        static_cast<float>(32 + r * std::sin(angle)),
                        static_cast<float>(32 + 0.1 * uniform())});
    }
    up.assign(points.size(), {0, 0, 1});
    chords.assign(points.size() * points.size(), 1);
  }
  GapPolygon view() const { return {points, up, up, chords}; }

  AnalyticField field;
  std::vector<Vec3> points, up;
  std::vector<std::uint8_t> chords;
};

template <StitchMode mode>
void triangulate_gap(benchmark::State& state) {
  DiscGap gap(static_cast<int>(state.range(0)));
  GapTriangulator triangulator;
  const GapRules rules{gap.field.view()};
  for (auto _ : state)
    if (!triangulator.run(gap.view(), rules, mode)) state.SkipWithError("no triangulation");
}
BENCHMARK(triangulate_gap<StitchMode::exact>)->Arg(6)->Arg(16)->Arg(32)->Arg(64)->Arg(128);
BENCHMARK(triangulate_gap<StitchMode::paper>)->Arg(6)->Arg(16)->Arg(32)->Arg(64)->Arg(128);

/// A torus with holes of about `corners` edges all over it: each the triangles round an edge path.
TriangleMesh torus_with_holes(int corners) {
  constexpr int kAround = 60, kAlong = 400;
  const TriangleMesh whole = moved(torus(64, 9.5f, kAlong, kAround), {80, 80, 80});
  const int length = (corners - 2) / 2;  // quadrilaterals in a row
  TriangleMesh mesh;
  mesh.vertices = whole.vertices;
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      const bool hole = i % (length + 2) < length && j % 3 == 0 && i + 2 < kAlong;
      const auto first = whole.triangles.begin() + 6 * (kAround * i + j);
      if (!hole) mesh.triangles.insert(mesh.triangles.end(), first, first + 6);
    }
  return mesh;
}

void stitch_gaps(benchmark::State& state) {
  static AnalyticField field = torus_field(160, {80, 80, 80}, 64, 9.5f);
  const TriangleMesh mesh = torus_with_holes(static_cast<int>(state.range(0)));
  const auto backend = make_tbb_backend(static_cast<int>(state.range(1)), nullptr);
  const GapLoops loops = find_gap_loops(*backend, mesh);
  for (auto _ : state) {
    state.PauseTiming();
    TriangleMesh closed = mesh;
    state.ResumeTiming();
    stitch_gaps(*backend, field.view(), field.sizes(1.2f), StitchMode::exact, loops, closed);
  }
  state.counters["gaps"] = static_cast<double>(loops.count());
  state.counters["per_gap"] = benchmark::Counter(
      static_cast<double>(loops.count()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(stitch_gaps)
    ->ArgNames({"corners", "threads"})
    ->ArgsProduct({{4, 6, 10, 32}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vasamesh::test

BENCHMARK_MAIN();

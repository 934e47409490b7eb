/// The solve as a whole: every backend gives the bytes of the oneTBB backend, iteration by
/// iteration.

#include <gtest/gtest.h>

#include <cmath>

#include "stages/bricks.h"
#include "stages/poisson.h"
#include "support/backend_test.h"
#include "support/brick_sets.h"

namespace vasamesh {
namespace {

constexpr int kRadius = 3;  // bricks

struct Solution {
  std::vector<float> x;
  SolveOutcome outcome;
};

/// Solves on a shell of bricks whose outermost cells are known.
Solution solve(Backend& backend, int iterations) {
  const Bricks bricks = make_bricks(backend, shell_bricks(kRadius));
  const std::size_t cells = bricks.count * kBrickCells;
  const auto unknown = to_backend(backend, random_mask(cells, 1));
  const auto b = to_backend(backend, random_floats(cells, 2));
  auto x = to_backend(backend, random_floats(cells, 3));
  SolveWorkspace workspace;
  const LevelView level{0, bricks.view(), {1.25f, 0.8f, 0.61f}};
  Solution solution;
  solution.outcome =
      conjugate_gradient(backend, level, unknown.view(), b.view(), x.view(), iterations, workspace);
  solution.x = to_host(backend, x.view());
  return solution;
}

class ConjugateGradient : public BackendTest {};

TEST_P(ConjugateGradient, SameBytesAsOneTbb) {
  const auto tbb = open_backend("tbb");
  for (const int iterations : {1, 12, 200}) {
    const Solution got = solve(backend(), iterations), want = solve(*tbb, iterations);
    EXPECT_EQ(got.x, want.x) << iterations;
    EXPECT_EQ(got.outcome.iterations, want.outcome.iterations);
    EXPECT_EQ(got.outcome.initial_residual, want.outcome.initial_residual);
    EXPECT_EQ(got.outcome.residual, want.outcome.residual);
  }
}

TEST_P(ConjugateGradient, ReachesTheSolution) {
  const Solution few = solve(backend(), 12), many = solve(backend(), 2000);
  EXPECT_EQ(few.outcome.iterations, 12);
  EXPECT_LT(few.outcome.residual, 0.5 * few.outcome.initial_residual);
  EXPECT_LT(many.outcome.residual, 1e-5);
  EXPECT_LT(many.outcome.iterations, 2000);
}

INSTANTIATE_TEST_SUITE_P(Backends, ConjugateGradient, ::testing::ValuesIn(backend_names()),
                         test_name);

}  // namespace
}  // namespace vasamesh

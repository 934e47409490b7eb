/// The conjugate gradient's passes of every backend: the oracle's bytes, whatever the bricks.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "reference/poisson_reference.h"
#include "stages/bricks.h"
#include "support/backend_test.h"
#include "support/brick_sets.h"
#include "types/octree.h"

namespace vasamesh {
namespace {

constexpr float kUntouched = 12345.0f;
constexpr std::size_t kLead = 37;  // elements before each view: views need not start allocations

/// Bricks, fields and mask of one case, on the host and on a backend.
struct Case {
  Case(Backend& backend, int count, std::uint32_t seed)
      : level{random_bricks(count, seed), {1.25f, 0.8f, 0.61f}},
        bricks(make_bricks(backend, level.bricks)),
        cells(std::size_t{512} * count),
        unknown(random_mask(cells, seed + 1)),
        a(awkward_floats(cells, seed + 2)),
        b(awkward_floats(cells, seed + 3)),
        c(awkward_floats(cells, seed + 4)) {}

  LevelView view() const { return {0, bricks.view(), level.weights}; }
  std::size_t count() const { return bricks.count; }

  reference::Level level;
  Bricks bricks;
  std::size_t cells;
  std::vector<std::uint8_t> unknown;
  std::vector<float> a, b, c;
};

/// An array between untouched elements, of which it must stay clear.
template <class T>
class Guarded {
 public:
  Guarded(Backend& backend, const std::vector<T>& values)
      : backend_(backend), size_(values.size()) {
    std::vector<T> all(kLead, static_cast<T>(kUntouched));
    all.insert(all.end(), values.begin(), values.end());
    all.resize(size_ + 2 * kLead, static_cast<T>(kUntouched));
    buffer_ = to_backend(backend, all);
  }
  View<T> view() { return buffer_.view().subview(kLead, size_); }

  std::vector<T> values() {
    const std::vector<T> all = to_host(backend_, buffer_.view());
    for (std::size_t i = 0; i < kLead; ++i) {
      EXPECT_EQ(all[i], static_cast<T>(kUntouched)) << "before the view";
      EXPECT_EQ(all[kLead + size_ + i], static_cast<T>(kUntouched)) << "past the view";
    }
    return {all.begin() + kLead, all.begin() + kLead + static_cast<std::ptrdiff_t>(size_)};
  }

 private:
  Backend& backend_;
  std::size_t size_;
  Buffer<T> buffer_;
};

Guarded<float> blank(Backend& backend, std::size_t count) {
  return {backend, std::vector<float>(count, kUntouched)};
}

void expect_same_bytes(const std::vector<float>& got, const std::vector<float>& want) {
  ASSERT_EQ(got.size(), want.size());
  for (std::size_t i = 0; i < got.size(); ++i)
    ASSERT_EQ(std::memcmp(&got[i], &want[i], sizeof(float)), 0)
        << i << ": " << got[i] << " for " << want[i];
}

/// The partial sums are the contract's, and near the exact ones.
void expect_sums(const std::vector<float>& got, const std::vector<float>& a,
                 const std::vector<float>& b) {
  expect_same_bytes(got, reference::brick_sums(a, b));
  const auto exact = reference::exact_brick_sums(a, b);
  for (std::size_t i = 0; i < got.size(); ++i)
    EXPECT_NEAR(got[i], exact[i].sum, 1e-5 * exact[i].magnitude + 1e-30) << i;
}

class PoissonPasses : public BackendTest {
 protected:
  /// body(case) for one brick, a few, and more than any work-group.
  template <class Body>
  void for_cases(const Body& body) {
    for (const int count : {1, 2, 27, 257}) {
      SCOPED_TRACE(count);
      Case example(backend(), count, 100u + static_cast<std::uint32_t>(count));
      body(example);
    }
  }
};

TEST_P(PoissonPasses, Residual) {
  for_cases([this](Case& on) {
    Guarded<std::uint8_t> unknown(backend(), on.unknown);
    Guarded<float> b(backend(), on.a), x(backend(), on.b),
        r = blank(backend(), on.cells), p = blank(backend(), on.cells),
        b_square = blank(backend(), on.count()), r_square = blank(backend(), on.count());
    backend().poisson_residual(on.view(), unknown.view(), b.view(), x.view(), r.view(), p.view(),
                               b_square.view(), r_square.view());
    std::vector<float> want = reference::poisson_apply(on.level, on.unknown, on.b), known = on.a;
    for (std::size_t i = 0; i < on.cells; ++i) {
      want[i] = on.unknown[i] ? on.a[i] - want[i] : 0.0f;
      if (!on.unknown[i]) known[i] = 0;
    }
    expect_same_bytes(r.values(), want);
    expect_same_bytes(p.values(), want);
    expect_sums(b_square.values(), known, known);
    expect_sums(r_square.values(), want, want);
    expect_same_bytes(b.values(), on.a);
    expect_same_bytes(x.values(), on.b);
  });
}

TEST_P(PoissonPasses, Energy) {
  for_cases([this](Case& on) {
    Guarded<std::uint8_t> unknown(backend(), on.unknown);
    Guarded<float> p(backend(), on.a), energy = blank(backend(), on.count());
    backend().poisson_energy(on.view(), unknown.view(), p.view(), energy.view());
    expect_sums(energy.values(), on.a, reference::poisson_apply(on.level, on.unknown, on.a));
    expect_same_bytes(p.values(), on.a);
  });
}

TEST_P(PoissonPasses, UpdateSolution) {
  for_cases([this](Case& on) {
    Guarded<std::uint8_t> unknown(backend(), on.unknown);
    Guarded<float> p(backend(), on.a), x(backend(), on.b), r(backend(), on.c),
        r_square = blank(backend(), on.count());
    const float alpha = 0.37f;
    backend().poisson_update_solution(on.view(), unknown.view(), alpha, p.view(), x.view(),
                                      r.view(), r_square.view());
    const std::vector<float> image = reference::poisson_apply(on.level, on.unknown, on.a);
    std::vector<float> want_x(on.cells), want_r(on.cells);
    for (std::size_t i = 0; i < on.cells; ++i) {
      want_x[i] = on.b[i] + alpha * on.a[i];
      want_r[i] = on.c[i] - alpha * image[i];
    }
    expect_same_bytes(x.values(), want_x);
    expect_same_bytes(r.values(), want_r);
    expect_sums(r_square.values(), want_r, want_r);
    expect_same_bytes(p.values(), on.a);
  });
}

TEST_P(PoissonPasses, UpdateDirection) {
  for_cases([this](Case& on) {
    Guarded<float> r(backend(), on.a), p(backend(), on.b);
    const float beta = 1.7f;
    backend().poisson_update_direction(on.view(), beta, r.view(), p.view());
    std::vector<float> want(on.cells);
    for (std::size_t i = 0; i < on.cells; ++i) want[i] = on.a[i] + beta * on.b[i];
    expect_same_bytes(p.values(), want);
  });
}

/// Without this the order of sums and products could not be told from another one.
TEST(PoissonReference, OrderAndContractionShow) {
  const std::vector<float> a = awkward_floats(512, 1), b = awkward_floats(512, 2);
  float in_order = 0, contracted[8] = {};
  for (std::size_t i = 0; i < 512; ++i) {
    in_order += a[i] * b[i];
    contracted[i % 8] = std::fma(a[i], b[i], contracted[i % 8]);
  }
  const float* lane = contracted;
  const float fused =
      ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
  EXPECT_NE(reference::brick_sums(a, b)[0], in_order);
  EXPECT_NE(reference::brick_sums(a, b)[0], fused);
}

TEST_P(PoissonPasses, NoBricks) {
  Case on(backend(), 1, 9);
  const LevelView nothing{0, {}, {1, 1, 1}};
  backend().poisson_residual(nothing, {}, {}, {}, {}, {}, {}, {});
  backend().poisson_energy(nothing, {}, {}, {});
  backend().poisson_update_solution(nothing, {}, 1, {}, {}, {}, {});
  backend().poisson_update_direction(nothing, 1, {}, {});
  EXPECT_EQ(backend().reduce_sum({}), 0.0f);
}

INSTANTIATE_TEST_SUITE_P(Backends, PoissonPasses, ::testing::ValuesIn(backend_names()), test_name);

}  // namespace
}  // namespace vasamesh

#include "stages/gradient_table.h"

#include <algorithm>
#include <cmath>

namespace vasamesh {

namespace {

constexpr double kCut = 3.0;  // standard deviations

/// exp(-t) by + and * alone, so that the table has the same bytes everywhere.
double exp_negative(double t) {
  constexpr int kTerms = 12, kSquarings = 6;
  const double small = -t / (1 << kSquarings);
  double term = 1, sum = 1;
  for (int i = 1; i <= kTerms; ++i) {
    term = term * small / i;
    sum += term;
  }
  for (int i = 0; i < kSquarings; ++i) sum *= sum;
  return sum;
}

struct Sum {
  double weight = 0, moment = 0;
};

/// The voxel `offset` away from a point's own, for a point at `fraction`.
Sum weigh(int offset, int fraction, double scale, double sigma) {
  const double distance = (offset + 0.5 - static_cast<double>(fraction) / kFractions) * scale;
  const double deviations = distance / sigma;
  if (std::fabs(deviations) > kCut) return {};
  const double weight =
      exp_negative(0.5 * deviations * deviations) - exp_negative(0.5 * kCut * kCut);
  return {weight, weight * distance};
}

GradientSum round_off(const Sum& s) {
  return {static_cast<float>(s.weight), static_cast<float>(s.moment)};
}

}  // namespace

GradientTable make_gradient_table(const Scale& scale, float sigma) {
  GradientTable table;
  for (int axis = 0; axis < 3; ++axis)
    table.reach[axis] =
        std::clamp(static_cast<int>(kCut * sigma / scale[axis] + 0.5), 1, kMaxGradientReach);
  for (int axis = 1; axis < 3; ++axis) {
    table.voxel[axis - 1].assign(kFractions * kMaxGradientSpan, GradientSum{0, 0});
    for (int f = 0; f < kFractions; ++f)
      for (int i = 0; i <= 2 * table.reach[axis]; ++i)
        table.voxel[axis - 1][f * kMaxGradientSpan + i] =
            round_off(weigh(i - table.reach[axis], f, scale[axis], sigma));
  }
  table.row.resize(kFractions * 512);
  for (int f = 0; f < kFractions; ++f)
    for (int half = 0; half < 2; ++half)
      for (int pattern = 0; pattern < 256; ++pattern) {
        Sum sum;
        for (int bit = 0; bit < 8; ++bit) {
          const int i = 8 * half + bit;
          if (!(pattern >> bit & 1) || i > 2 * table.reach[0]) continue;
          const Sum one = weigh(i - table.reach[0], f, scale[0], sigma);
          sum.weight += one.weight;
          sum.moment += one.moment;
        }
        table.row[(f * 2 + half) * 256 + pattern] = round_off(sum);
      }
  return table;
}

}  // namespace vasamesh

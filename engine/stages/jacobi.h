#pragma once

/// \file
/// Eigenvectors of symmetric 3 x 3 matrices by cyclic Jacobi rotations (Golub and Van Loan, "Matrix
/// Computations", section 8.5): a fixed number of sweeps in float32, so that every backend gives
/// the same bytes. `Lanes` says whether of one matrix or of several at once: its Number, and of
/// that any(mask), absolute and square_root.

#include <array>
#include <cmath>

namespace vasamesh {

inline constexpr int kJacobiSweeps = 5;

/// One matrix.
struct OneLane {
  using Number = float;
  static bool any(bool mask) { return mask; }
  static float absolute(float value) { return std::fabs(value); }
  static float square_root(float value) { return std::sqrt(value); }
};

/// One rotation that zeroes a[p][q]; r is the third index. Skipped where a[p][q] is below `least`.
template <class Lanes, class Number = typename Lanes::Number>
void jacobi_rotate(Number (&a)[3][3], Number (&v)[3][3], int p, int q, int r, const Number& least) {
  const Number apq = a[p][q];
  const auto turned = Lanes::absolute(apq) > least;
  if (!Lanes::any(turned)) return;
  const Number theta = (a[q][q] - a[p][p]) / (2.0f * apq);
  const Number size = 1.0f / (Lanes::absolute(theta) + Lanes::square_root(theta * theta + 1.0f));
  const Number t = theta < 0.0f ? -size : size;
  const Number c = 1.0f / Lanes::square_root(t * t + 1.0f);
  const Number s = t * c;
  const auto set = [&](Number& entry, const Number& value) { entry = turned ? value : entry; };
  set(a[p][p], a[p][p] - t * apq);
  set(a[q][q], a[q][q] + t * apq);
  set(a[p][q], Number{});
  const Number arp = a[r][p], arq = a[r][q];
  set(a[r][p], c * arp - s * arq);
  set(a[r][q], s * arp + c * arq);
  a[q][p] = a[p][q], a[p][r] = a[r][p], a[q][r] = a[r][q];
  for (auto& row : v) {
    const Number vip = row[p], viq = row[q];
    set(row[p], c * vip - s * viq);
    set(row[q], s * vip + c * viq);
  }
}

/// The unit eigenvector of the smallest eigenvalue of a positive semi-definite matrix, of which the
/// diagonal of the eigenvalues is left.
template <class Lanes, class Number = typename Lanes::Number>
std::array<Number, 3> least_eigenvector(Number (&a)[3][3]) {
  const Number one = Number{} + 1.0f;
  Number v[3][3] = {{one, {}, {}}, {{}, one, {}}, {{}, {}, one}};
  const Number least = 1e-7f * ((a[0][0] + a[1][1]) + a[2][2]);
  for (int sweep = 0; sweep < kJacobiSweeps; ++sweep) {
    jacobi_rotate<Lanes>(a, v, 0, 1, 2, least);
    jacobi_rotate<Lanes>(a, v, 0, 2, 1, least);
    jacobi_rotate<Lanes>(a, v, 1, 2, 0, least);
  }
  const auto second = a[1][1] < a[0][0];
  const auto third = a[2][2] < (second ? a[1][1] : a[0][0]);
  std::array<Number, 3> vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const Number first_two = second ? v[i][1] : v[i][0];
    vector[i] = third ? v[i][2] : first_two;
  }
  return vector;
}

}  // namespace vasamesh

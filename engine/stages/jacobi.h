#pragma once

/// \file
/// Eigenvalues and eigenvectors of a symmetric 3 x 3 matrix by cyclic Jacobi rotations (Golub and
/// Van Loan, "Matrix Computations", section 8.5): a fixed number of sweeps in float32, so that
/// every backend gives the same bytes.

#include <array>
#include <cmath>

namespace vasamesh {

inline constexpr int kJacobiSweeps = 5;

/// Ascending eigenvalues; vector[i] is the unit eigenvector of value[i].
struct Eigen3 {
  std::array<float, 3> value;
  std::array<std::array<float, 3>, 3> vector;
};

/// One rotation that zeroes a[p][q]; r is the third index. Skipped where a[p][q] is below `least`.
inline void jacobi_rotate(float a[3][3], float v[3][3], int p, int q, int r, float least) {
  const float apq = a[p][q];
  if (std::fabs(apq) <= least) return;
  const float theta = (a[q][q] - a[p][p]) / (2.0f * apq);
  const float t_size = 1.0f / (std::fabs(theta) + std::sqrt(theta * theta + 1.0f));
  const float t = theta < 0.0f ? -t_size : t_size;
  const float c = 1.0f / std::sqrt(t * t + 1.0f);
  const float s = t * c;
  a[p][p] = a[p][p] - t * apq;
  a[q][q] = a[q][q] + t * apq;
  a[p][q] = a[q][p] = 0.0f;
  const float arp = a[r][p], arq = a[r][q];
  a[r][p] = a[p][r] = c * arp - s * arq;
  a[r][q] = a[q][r] = s * arp + c * arq;
  for (int i = 0; i < 3; ++i) {
    const float vip = v[i][p], viq = v[i][q];
    v[i][p] = c * vip - s * viq;
    v[i][q] = s * vip + c * viq;
  }
}

/// \param xx, xy, ...  the six entries of a positive semi-definite matrix.
inline Eigen3 eigen_symmetric(float xx, float xy, float xz, float yy, float yz, float zz) {
  float a[3][3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
  float v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const float least = 1e-7f * ((xx + yy) + zz);
  for (int sweep = 0; sweep < kJacobiSweeps; ++sweep) {
    jacobi_rotate(a, v, 0, 1, 2, least);
    jacobi_rotate(a, v, 0, 2, 1, least);
    jacobi_rotate(a, v, 1, 2, 0, least);
  }
  int order[3] = {0, 1, 2};
  const auto sort_pair = [&](int i, int j) {
    if (a[order[j]][order[j]] >= a[order[i]][order[i]]) return;
    const int swapped = order[i];
    order[i] = order[j];
    order[j] = swapped;
  };
  sort_pair(0, 1);
  sort_pair(1, 2);
  sort_pair(0, 1);
  Eigen3 eigen;
  for (int i = 0; i < 3; ++i) {
    const int column = order[i];
    eigen.value[i] = a[column][column];
    for (int j = 0; j < 3; ++j) eigen.vector[i][j] = v[j][column];
  }
  return eigen;
}

}  // namespace vasamesh

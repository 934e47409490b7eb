#pragma once

/// \file
/// Marching tetrahedra on a cube of lattice nodes cut into six (Freudenthal), as one table over the
/// 256 labellings of the cube's corners. Corner c is at (c & 1, c >> 1 & 1, c >> 2 & 1).

#include <array>
#include <cstdint>

namespace vasamesh {

/// The triangles of one labelling. A vertex lies on a cube edge, given by its lower corner and its
/// direction (1..7): corner + 8 * direction. Counter-clockwise seen from outside.
struct CubeCase {
  std::uint8_t count = 0;  ///< triangles, at most 12
  std::array<std::array<std::uint8_t, 3>, 12> triangles{};
};

namespace detail {

constexpr std::uint8_t cube_edge(int a, int b) {
  const int low = a < b ? a : b, high = a < b ? b : a;
  return static_cast<std::uint8_t>(low + 8 * (high - low));
}

/// Twice the midpoint of an edge along one axis.
constexpr int doubled_midpoint(std::uint8_t edge, int axis) {
  const int low = edge & 7, high = low + (edge >> 3);
  return (low >> axis & 1) + (high >> axis & 1);
}

constexpr int doubled_normal_dot(const std::array<std::uint8_t, 3>& t, const int (&out)[3]) {
  int u[3]{}, v[3]{};
  for (int i = 0; i < 3; ++i) {
    u[i] = doubled_midpoint(t[1], i) - doubled_midpoint(t[0], i);
    v[i] = doubled_midpoint(t[2], i) - doubled_midpoint(t[0], i);
  }
  return (u[1] * v[2] - u[2] * v[1]) * out[0] + (u[2] * v[0] - u[0] * v[2]) * out[1] +
         (u[0] * v[1] - u[1] * v[0]) * out[2];
}

/// Adds a triangle, turned so that it faces from the inside corners to the outside ones.
constexpr void add_triangle(CubeCase& cube, std::array<std::uint8_t, 3> t, const int (&out)[3]) {
  if (doubled_normal_dot(t, out) < 0) {
    const std::uint8_t swapped = t[1];
    t[1] = t[2];
    t[2] = swapped;
  }
  cube.triangles[cube.count++] = t;
}

constexpr void add_tetrahedron(CubeCase& cube, const int (&corner)[4], int labels) {
  int inside[4]{}, outside[4]{}, in = 0, out = 0;
  for (const int c : corner) {
    if (labels >> c & 1)
      inside[in++] = c;
    else
      outside[out++] = c;
  }
  if (in == 0 || out == 0) return;
  int direction[3]{};  // from the inside corners' centroid to the outside ones', times in * out
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < out; ++i) direction[axis] += in * (outside[i] >> axis & 1);
    for (int i = 0; i < in; ++i) direction[axis] -= out * (inside[i] >> axis & 1);
  }
  if (in == 2) {
    const std::uint8_t q[4] = {cube_edge(inside[0], outside[0]), cube_edge(inside[0], outside[1]),
                               cube_edge(inside[1], outside[1]), cube_edge(inside[1], outside[0])};
    add_triangle(cube, {q[0], q[1], q[2]}, direction);
    add_triangle(cube, {q[0], q[2], q[3]}, direction);
  } else {
    const int lone = in == 1 ? inside[0] : outside[0];
    const int* others = in == 1 ? outside : inside;
    add_triangle(
        cube, {cube_edge(lone, others[0]), cube_edge(lone, others[1]), cube_edge(lone, others[2])},
        direction);
  }
}

constexpr std::array<CubeCase, 256> make_cube_cases() {
  constexpr int kOrders[6][2] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  std::array<CubeCase, 256> cases{};
  for (int labels = 0; labels < 256; ++labels)
    for (const auto& order : kOrders) {
      const int first = 1 << order[0], second = first | 1 << order[1];
      add_tetrahedron(cases[static_cast<std::size_t>(labels)], {0, first, second, 7}, labels);
    }
  return cases;
}

}  // namespace detail

inline constexpr std::array<CubeCase, 256> kCubeCases = detail::make_cube_cases();

}  // namespace vasamesh

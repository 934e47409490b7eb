#include "stages/surface.h"

#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "types/volume.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

/// position = offset + matrix * padded voxel position, row-major.
struct Affine {
  std::array<double, 9> matrix;
  std::array<double, 3> offset;

  double determinant() const {
    const auto& m = matrix;
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
           m[2] * (m[3] * m[7] - m[4] * m[6]);
  }
};

/// Padded voxel (x, y, z) spans [x, x + 1], and the caller's voxel 0 is padded voxel kPad, so that
/// its centre lies at kPad + 0.5.
Affine voxel_to_space(const Geometry& geometry, Space space) {
  Affine affine{};
  for (std::size_t row = 0; row < 3; ++row) {
    const double sign = space == Space::ras && row < 2 ? -1.0 : 1.0;
    affine.offset[row] = space == Space::voxel ? 0.0 : sign * geometry.origin[row];
    for (std::size_t column = 0; column < 3; ++column) {
      const double direction = space == Space::voxel ? (row == column ? 1.0 : 0.0)
                                                     : geometry.direction[3 * row + column];
      const double entry = sign * direction * geometry.spacing[column];
      affine.matrix[3 * row + column] = entry;
      affine.offset[row] -= entry * (kPad + 0.5);
    }
  }
  return affine;
}

}  // namespace

TriangleMesh extract_base_surface(Backend& backend, const Lattice& lattice) {
  const BrickView bricks = lattice.bricks.view();
  const std::size_t nodes = bricks.count * kBrickCells;
  Buffer<std::uint8_t> crossed(backend, nodes);
  Buffer<std::uint16_t> node_start(backend, nodes);
  Buffer<std::uint32_t> vertex_start(backend, bricks.count + 1);
  Buffer<std::uint32_t> triangle_start(backend, bricks.count + 1);
  const auto vertex_counts = vertex_start.view().subview(0, bricks.count);
  const auto triangle_counts = triangle_start.view().subview(0, bricks.count);
  backend.surface_count(bricks, lattice.state.view(), crossed.view(), node_start.view(),
                        vertex_counts, triangle_counts);
  const std::size_t vertex_total = backend.exclusive_scan(vertex_counts, vertex_start.view());
  const std::size_t triangle_total = backend.exclusive_scan(triangle_counts, triangle_start.view());
  if (3 * triangle_total > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::refused,
                "the surface has more than 2^32 corners: convert a part of the volume");

  Buffer<float> vertices(backend, 3 * vertex_total);
  Buffer<std::uint32_t> triangles(backend, 3 * triangle_total);
  backend.surface_emit(bricks, lattice.state.view(), lattice.values.view(), kVertexMargin,
                       crossed.view(), node_start.view(), vertex_start.view(),
                       triangle_start.view(), vertices.view(), triangles.view());
  TriangleMesh mesh;
  resize_in_steps(backend, vertices.size(), mesh.vertices);
  resize_in_steps(backend, triangles.size(), mesh.triangles);
  backend.download<float>(vertices.view(), mesh.vertices);
  backend.download<std::uint32_t>(triangles.view(), mesh.triangles);
  return mesh;
}

void place_in_space(Backend& backend, const Geometry& geometry, Space space, TriangleMesh& mesh) {
  const Affine affine = voxel_to_space(geometry, space);
  constexpr std::size_t kGrain = 8192;  // vertices or triangles a task takes
  for_each_index(backend, mesh.vertex_count(), kGrain, [&](std::size_t v) {
    float* p = &mesh.vertices[3 * v];
    const double x = p[0], y = p[1], z = p[2];
    for (std::size_t row = 0; row < 3; ++row)
      p[row] = static_cast<float>(affine.matrix[3 * row] * x + affine.matrix[3 * row + 1] * y +
                                  affine.matrix[3 * row + 2] * z + affine.offset[row]);
  });
  if (affine.determinant() > 0) return;
  for_each_index(backend, mesh.triangle_count(), kGrain, [&](std::size_t t) {
    std::swap(mesh.triangles[3 * t + 1], mesh.triangles[3 * t + 2]);
  });
}

}  // namespace vasamesh

/// The base surface: marching tetrahedra of the labelled cell lattice.

#include <algorithm>
#include <array>
#include <bit>

#include "types/lattice_access.h"
#include "tbb/tbb_backend.h"
#include "types/tetrahedra.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;  // bricks a task takes

/// The labels of a brick's nodes and of those one further along each axis.
struct LabelHalo {
  LabelHalo(const std::int32_t* near, const std::uint8_t* state) {
    for (int z = 0; z < 9; ++z)
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x) {
          const std::size_t node = node_at(near, x, y, z);
          known[z][y][x] = node != kNoNode;
          label[z][y][x] = node != kNoNode && (state[node] & kLabel);
        }
  }
  /// The labels of the cube from (x, y, z); 0 (nothing to do) where a corner is not there.
  int cube(int x, int y, int z) const {
    int labels = 0;
    for (int c = 0; c < 8; ++c) {
      const int i = x + (c & 1), j = y + (c >> 1 & 1), k = z + (c >> 2 & 1);
      if (!known[k][j][i]) return 0;
      labels |= label[k][j][i] << c;
    }
    return labels;
  }
  bool known[9][9][9];
  std::uint8_t label[9][9][9];
};

/// The index of the vertex on an edge of the cube whose lowest node is at (x, y, z).
struct VertexIds {
  std::uint32_t of(int x, int y, int z, std::uint8_t edge) const {
    const int corner = edge & 7, direction = edge >> 3;
    const std::size_t node =
        node_at(near, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1));
    const auto before = static_cast<std::uint8_t>(crossed[node] & ((1u << (direction - 1)) - 1));
    return vertex_start[node / kBrickCells] + node_start[node] +
           static_cast<std::uint32_t>(std::popcount(before));
  }
  const std::int32_t* near;
  const std::uint8_t* crossed;
  const std::uint16_t* node_start;
  const std::uint32_t* vertex_start;
};

}  // namespace

void TbbBackend::surface_count(const BrickView& bricks, View<const std::uint8_t> state,
                               View<std::uint8_t> crossed, View<std::uint16_t> node_start,
                               View<std::uint32_t> vertices, View<std::uint32_t> triangles) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    const LabelHalo halo(bricks.neighbours.data() + 27 * brick, state.data());
    std::uint32_t vertex_count = 0, triangle_count = 0;
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const int x = cell & 7, y = cell >> 3 & 7, z = cell >> 6;
      std::uint8_t edges = 0;
      for (int d = 1; d < 8; ++d) {
        const int i = x + (d & 1), j = y + (d >> 1 & 1), k = z + (d >> 2);
        if (halo.known[k][j][i] && halo.label[k][j][i] != halo.label[z][y][x])
          edges |= static_cast<std::uint8_t>(1u << (d - 1));
      }
      const std::size_t node = kBrickCells * brick + cell;
      crossed[node] = edges;
      node_start[node] = static_cast<std::uint16_t>(vertex_count);
      vertex_count += static_cast<std::uint32_t>(std::popcount(edges));
      triangle_count += kCubeCases[static_cast<std::size_t>(halo.cube(x, y, z))].count;
    }
    vertices[brick] = vertex_count;
    triangles[brick] = triangle_count;
  });
}

void TbbBackend::surface_emit(const BrickView& bricks, View<const std::uint8_t> state,
                              View<const float> values, float margin,
                              View<const std::uint8_t> crossed,
                              View<const std::uint16_t> node_start,
                              View<const std::uint32_t> vertex_start,
                              View<const std::uint32_t> triangle_start, View<float> vertices,
                              View<std::uint32_t> triangles) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    if (vertex_start[brick] == vertex_start[brick + 1] &&
        triangle_start[brick] == triangle_start[brick + 1])
      return;
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    const BrickCoord coord = bricks.coords[brick];
    const LabelHalo halo(near, state.data());
    const VertexIds ids{near, crossed.data(), node_start.data(), vertex_start.data()};
    float* vertex = vertices.data() + 3 * std::size_t{vertex_start[brick]};
    std::uint32_t* corner = triangles.data() + 3 * std::size_t{triangle_start[brick]};
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const int x = cell & 7, y = cell >> 3 & 7, z = cell >> 6;
      const std::size_t node = kBrickCells * brick + cell;
      for (int d = 1; d < 8; ++d) {
        if (!(crossed[node] >> (d - 1) & 1)) continue;
        const int step[3] = {d & 1, d >> 1 & 1, d >> 2};
        const float a = values[node],
                    b = values[node_at(near, x + step[0], y + step[1], z + step[2])];
        const float t = std::min(std::max(a / (a - b), margin), 1.0f - margin);
        const int own[3] = {8 * coord.x + x, 8 * coord.y + y, 8 * coord.z + z};
        for (int i = 0; i < 3; ++i)
          *vertex++ = 0.5f * (static_cast<float>(own[i]) + t * static_cast<float>(step[i]));
      }
      const CubeCase& cube = kCubeCases[static_cast<std::size_t>(halo.cube(x, y, z))];
      for (int i = 0; i < cube.count; ++i)
        for (const std::uint8_t edge : cube.triangles[static_cast<std::size_t>(i)])
          *corner++ = ids.of(x, y, z, edge);
    }
  });
}

}  // namespace vasamesh

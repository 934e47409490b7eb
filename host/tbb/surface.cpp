/// The base surface: marching tetrahedra of the labelled cell lattice.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "tbb/byte_rows.h"
#include "tbb/tbb_backend.h"
#include "types/lattice_access.h"
#include "types/tetrahedra.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;  // bricks a task takes

/// The labels of a brick's nodes and of those one further along each axis, as rows of bits.
struct LabelHalo {
  LabelHalo(const std::int32_t* near, const std::uint8_t* state) {
    for (int z = 0; z < 9; ++z)
      for (int y = 0; y < 9; ++y) {
        const std::size_t own = node_at(near, 0, y, z), next = node_at(near, 8, y, z);
        known[z][y] = (own == kNoNode ? 0 : 0xffu) | (next == kNoNode ? 0 : 0x100u);
        label[z][y] = (own == kNoNode ? 0 : byte_bits(load_bytes(state + own), kLabel)) |
                      (next == kNoNode ? 0 : (state[next] & std::uint32_t{kLabel}) << 8);
      }
  }

  /// The nodes of row (y, z) whose edge along direction d the labels cross.
  std::uint32_t crossed(int y, int z, int d) const {
    const int j = y + (d >> 1 & 1), k = z + (d >> 2);
    return (label[z][y] ^ label[k][j] >> (d & 1)) & known[k][j] >> (d & 1) & 0xffu;
  }

  /// The cubes from the nodes of a row whose corners differ and are all there.
  std::uint32_t mixed(int y, int z) const {
    std::uint32_t any = 0, all = ~0u, there = ~0u;
    for (int k = z; k <= z + 1; ++k)
      for (int j = y; j <= y + 1; ++j) {
        any |= label[k][j] | label[k][j] >> 1;
        all &= label[k][j] & label[k][j] >> 1;
        there &= known[k][j] & known[k][j] >> 1;
      }
    return any & ~all & there & 0xffu;
  }

  /// The labels of the cube from (x, y, z).
  std::size_t cube(int x, int y, int z) const {
    return (label[z][y] >> x & 3) | (label[z][y + 1] >> x & 3) << 2 |
           (label[z + 1][y] >> x & 3) << 4 | (label[z + 1][y + 1] >> x & 3) << 6;
  }

  std::uint32_t known[9][9];  // z, y; bit x
  std::uint32_t label[9][9];
};

/// Where the vertices of the edges of a cube's corners begin, and which edges have one.
struct CubeVertices {
  CubeVertices(const std::int32_t* near, const std::uint8_t* crossed,
               const std::uint16_t* node_start, const std::uint32_t* vertex_start, int x, int y,
               int z) {
    for (int c = 0; c < 7; ++c) {  // the last has no edge in the cube
      const std::size_t node = node_at(near, x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
      edges[c] = crossed[node];
      first[c] = vertex_start[node / kBrickCells] + node_start[node];
    }
  }
  /// The index of the vertex on an edge (lower corner + 8 * direction).
  std::uint32_t of(std::uint8_t edge) const {
    const int corner = edge & 7, direction = edge >> 3;
    const std::uint32_t before = edges[corner] & ((1u << (direction - 1)) - 1);
    return first[corner] + static_cast<std::uint32_t>(std::popcount(before));
  }
  std::uint32_t edges[7], first[7];
};

}  // namespace

void TbbBackend::surface_count(const BrickView& bricks, View<const std::uint8_t> state,
                               View<std::uint8_t> crossed, View<std::uint16_t> node_start,
                               View<std::uint32_t> vertices, View<std::uint32_t> triangles) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    const LabelHalo halo(bricks.neighbours.data() + 27 * brick, state.data());
    std::uint32_t vertex_count = 0, triangle_count = 0;
    for (int row = 0; row < kBrickRows; ++row) {
      const int y = row & 7, z = row >> 3;
      std::uint64_t edges = 0;
      for (int d = 1; d < 8; ++d) edges |= bit_bytes(halo.crossed(y, z, d)) << (d - 1);
      std::uint8_t* own = crossed.data() + kBrickCells * brick + 8 * row;
      std::uint16_t* start = node_start.data() + kBrickCells * brick + 8 * row;
      std::memcpy(own, &edges, sizeof(edges));
      for (int x = 0; x < 8; ++x) {
        start[x] = static_cast<std::uint16_t>(vertex_count);
        if (edges) vertex_count += static_cast<std::uint32_t>(std::popcount(own[x]));
      }
      for_each_bit(halo.mixed(y, z),
                   [&](int x) { triangle_count += kCubeCases[halo.cube(x, y, z)].count; });
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
    float* vertex = vertices.data() + 3 * std::size_t{vertex_start[brick]};
    std::uint32_t* corner = triangles.data() + 3 * std::size_t{triangle_start[brick]};
    const auto emit_vertices = [&](int x, int y, int z) {
      const std::size_t node = kBrickCells * brick + static_cast<std::size_t>(brick_cell(x, y, z));
      const int own[3] = {8 * coord.x + x, 8 * coord.y + y, 8 * coord.z + z};
      for_each_bit(crossed[node], [&](int edge) {
        const int d = edge + 1, step[3] = {d & 1, d >> 1 & 1, d >> 2};
        const float a = values[node],
                    b = values[node_at(near, x + step[0], y + step[1], z + step[2])];
        const float t = std::min(std::max(a / (a - b), margin), 1.0f - margin);
        for (int i = 0; i < 3; ++i)
          *vertex++ = 0.5f * (static_cast<float>(own[i]) + t * static_cast<float>(step[i]));
      });
    };
    const auto emit_triangles = [&](int x, int y, int z) {
      const CubeVertices ids(near, crossed.data(), node_start.data(), vertex_start.data(), x, y, z);
      const CubeCase& cube = kCubeCases[halo.cube(x, y, z)];
      for (std::size_t i = 0; i < cube.count; ++i)
        for (const std::uint8_t edge : cube.triangles[i]) *corner++ = ids.of(edge);
    };
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y) {
        std::uint32_t with_vertices = 0;
        for (int d = 1; d < 8; ++d) with_vertices |= halo.crossed(y, z, d);
        for_each_bit(with_vertices, [&](int x) { emit_vertices(x, y, z); });
        for_each_bit(halo.mixed(y, z), [&](int x) { emit_triangles(x, y, z); });
      }
  });
}

}  // namespace vasamesh

/// The cell lattice: which bricks and nodes matter, the solid's labels, the field at the nodes.

#include <algorithm>
#include <array>
#include <cstring>

#include "tbb/byte_rows.h"
#include "tbb/tbb_backend.h"
#include "types/row_bits.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;  // bricks a task takes

// Round a brick of nodes 0..7 lie the nodes -4..11 and the voxels -3..5; a row of either is a
// bit pattern, lowest first.
constexpr int kNodes = 16;
constexpr int kVoxels = 9;
constexpr int kNodeMargin = 4;
constexpr int kVoxelMargin = 3;

using VoxelRows = std::uint32_t[kVoxels][kVoxels];  // [z][y]
using NodeRows = std::uint16_t[kNodes][kNodes];     // [z][y]
using OwnRows = std::uint16_t[8][8];                // [z][y], those of the brick; nodes from -4

/// Bit i to bit 2 i.
constexpr std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 4) & 0x0f0fu;
  bits = (bits | bits << 2) & 0x3333u;
  return (bits | bits << 1) & 0x5555u;
}

/// kVoxels voxels from (x, y, z), background outside the volume.
std::uint32_t voxel_row(const BitView& object, int x, int y, int z) {
  if (y < 0 || z < 0 || y >= object.size[1] || z >= object.size[2]) return 0;
  return row_bits(object.words.data() + object.row(y, z), object.words_per_row, x, kVoxels);
}

/// \return false where all voxels are alike, so that there is no boundary.
bool load_voxels(const BitView& object, const BrickCoord& c, VoxelRows& rows) {
  std::uint32_t any = 0, all = ~0u;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y) {
      rows[z][y] = voxel_row(object, 4 * c.x - kVoxelMargin, 4 * c.y + y - kVoxelMargin,
                             4 * c.z + z - kVoxelMargin);
      any |= rows[z][y];
      all &= rows[z][y];
    }
  return any != 0 && (all & ((1u << kVoxels) - 1)) != (1u << kVoxels) - 1;
}

/// The centres of faces between object and background. Node y of the extended brick is at -4 + y;
/// even ones lie between voxels y / 2 and y / 2 + 1 of the rows, odd ones at voxel (y + 1) / 2.
void mark_face_centres(const VoxelRows& voxels, NodeRows& rows) {
  const auto odd_nodes = [](std::uint32_t row) {
    return static_cast<std::uint16_t>(spread(row >> 1 & 0xffu) << 1);
  };
  for (int z = 0; z < kVoxels - 1; ++z)
    for (int y = 0; y < kVoxels - 1; ++y) {
      const std::uint32_t own = voxels[z + 1][y + 1];
      rows[2 * z][2 * y] = 0;
      rows[2 * z][2 * y + 1] = odd_nodes(own ^ voxels[z][y + 1]);
      rows[2 * z + 1][2 * y] = odd_nodes(own ^ voxels[z + 1][y]);
      rows[2 * z + 1][2 * y + 1] = static_cast<std::uint16_t>(spread((own ^ own >> 1) & 0xffu));
    }
}

/// Box dilation by `radius` nodes along each axis, at most kNodeMargin; `rows` is used up.
void dilate(NodeRows& rows, const std::array<int, 3>& radius, OwnRows& own) {
  for (auto& plane : rows)
    for (std::uint16_t& row : plane) {
      std::uint32_t bits = row;
      for (int r = 1; r <= radius[0]; ++r)
        bits |= std::uint32_t{row} << r | std::uint32_t{row} >> r;
      row = static_cast<std::uint16_t>(bits);
    }
  std::uint16_t along_y[kNodes][8] = {};
  for (int z = 0; z < kNodes; ++z)
    for (int k = kNodeMargin - radius[1]; k <= kNodeMargin + radius[1]; ++k)
      for (int y = 0; y < 8; ++y) along_y[z][y] |= rows[z][y + k];
  std::memset(own, 0, sizeof(own));
  for (int z = 0; z < 8; ++z)
    for (int k = kNodeMargin - radius[2]; k <= kNodeMargin + radius[2]; ++k)
      for (int y = 0; y < 8; ++y) own[z][y] |= along_y[z + k][y];
}

/// Eight bits of the brick's own nodes in a row of the extended ones.
constexpr std::uint32_t own_row(std::uint32_t bits) { return bits >> kNodeMargin & 0xffu; }

/// Labels of the nodes 0..7 of a row from the voxel rows that it touches, joined by `join`.
template <class Join>
std::uint32_t label_row(const VoxelRows& voxels, int y, int z, const Join& join) {
  // Node y even touches the voxels y / 2 - 1 and y / 2, row y / 2 + 2 and y / 2 + 3.
  const int y1 = y / 2 + kVoxelMargin, z1 = z / 2 + kVoxelMargin;
  const int y0 = y & 1 ? y1 : y1 - 1, z0 = z & 1 ? z1 : z1 - 1;
  const std::uint32_t u =
      join(join(voxels[z0][y0], voxels[z0][y1]), join(voxels[z1][y0], voxels[z1][y1]));
  return spread(join(u >> 2, u >> 3) & 15u) | spread(u >> 3 & 15u) << 1;
}

/// The corner nodes of a row (y and z even, 0 to 8) that two object voxels alone touch, opposite
/// over the corner; bits 0, 2 .. 8.
std::uint32_t corner_contacts(const VoxelRows& voxels, int y, int z) {
  const int y1 = y / 2 + kVoxelMargin, z1 = z / 2 + kVoxelMargin;
  std::uint32_t contacts = 0;
  for (int x = 0; x <= 8; x += 2) {
    const int x0 = x / 2 + kVoxelMargin - 1;
    std::uint32_t corner = 0;
    for (int k = 0; k < 4; ++k)
      corner |= (voxels[z1 - 1 + k / 2][y1 - 1 + k % 2] >> x0 & 3u) << 2 * k;
    if (corner == 0x81 || corner == 0x42 || corner == 0x24 || corner == 0x18) contacts |= 1u << x;
  }
  return contacts;
}

/// The nodes of a row at such contacts: the corners, and the edges that end there. (Edges alone
/// would still join the two voxels, since the cut joins their midpoints across the corner.)
std::uint32_t trimmed_row(const VoxelRows& voxels, int y, int z) {
  if ((y & 1) && (z & 1)) return 0;
  if (y & 1) return corner_contacts(voxels, y - 1, z) | corner_contacts(voxels, y + 1, z);
  if (z & 1) return corner_contacts(voxels, y, z - 1) | corner_contacts(voxels, y, z + 1);
  const std::uint32_t corners = corner_contacts(voxels, y, z);
  return corners | corners << 1 | corners >> 1;
}

std::uint32_t solid_row(const VoxelRows& voxels, int connectivity, int y, int z) {
  const auto any = [](std::uint32_t a, std::uint32_t b) { return a | b; };
  const auto all = [](std::uint32_t a, std::uint32_t b) { return a & b; };
  if (connectivity == 6) return label_row(voxels, y, z, all);
  const std::uint32_t row = label_row(voxels, y, z, any);
  return connectivity == 18 ? row & ~trimmed_row(voxels, y, z) : row;
}

/// Values at the nodes of a brick from the refined level, whose cells lie between the nodes.
void sample_refined(const std::int32_t* near, const float* field, float* out) {
  float c[9][9][9];
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 9; ++x) {
        const int gx = x + 7, gy = y + 7, gz = z + 7;  // cells -1..7 from 8 below
        const std::int32_t from = near[(gx >> 3) + 3 * ((gy >> 3) + 3 * (gz >> 3))];
        c[z][y][x] = field[std::size_t{kBrickCells} * from + brick_cell(gx & 7, gy & 7, gz & 7)];
      }
  float cx[9][9][8], cy[9][8][8];
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 8; ++x) cx[z][y][x] = 0.5f * (c[z][y][x] + c[z][y][x + 1]);
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) cy[z][y][x] = 0.5f * (cx[z][y][x] + cx[z][y + 1][x]);
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) out[brick_cell(x, y, z)] = 0.5f * (cy[z][y][x] + cy[z + 1][y][x]);
}

/// The spline between cells (even node) or at a cell's centre (odd node).
inline float spline_node(int node, float below, float own, float above) {
  return node & 1 ? 0.125f * (below + above) + 0.75f * own : 0.5f * (below + own);
}

/// Values at the nodes of a brick from the regular level: the brick is an octant of a regular one.
void sample_regular(const std::int32_t* near, const BrickCoord& coord, const float* field,
                    float* out) {
  const int base[3] = {(coord.x & 1) * 4 + 7, (coord.y & 1) * 4 + 7, (coord.z & 1) * 4 + 7};
  float c[6][6][6], cx[6][6][8], cy[6][8][8];
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) {
        const int gx = base[0] + x, gy = base[1] + y, gz = base[2] + z;
        const std::int32_t from = near[(gx >> 3) + 3 * ((gy >> 3) + 3 * (gz >> 3))];
        c[z][y][x] =
            from == kNoBrick
                ? 0.0f
                : field[std::size_t{kBrickCells} * from + brick_cell(gx & 7, gy & 7, gz & 7)];
      }
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) {
        const float* row = c[z][y] + x / 2;
        cx[z][y][x] = spline_node(x, row[0], row[1], row[2]);
      }
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        cy[z][y][x] = spline_node(y, cx[z][y / 2][x], cx[z][y / 2 + 1][x], cx[z][y / 2 + 2][x]);
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        out[brick_cell(x, y, z)] =
            spline_node(z, cy[z / 2][y][x], cy[z / 2 + 1][y][x], cy[z / 2 + 2][y][x]);
}

/// The refined level has the cells on both sides of each node: the brick and the seven below it.
bool refined_here(const std::int32_t* near) {
  for (int n = 0; n < 8; ++n)
    if (near[brick_neighbour(-(n & 1), -(n >> 1 & 1), -(n >> 2 & 1))] == kNoBrick) return false;
  return true;
}

}  // namespace

void TbbBackend::lattice_mark(const BitView& object, const BrickView& bricks,
                              const std::array<int, 3>& radius, View<std::uint8_t> used) {
  const std::array<int, 3> reach = {radius[0] + 1, radius[1] + 1, radius[2] + 1};
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    VoxelRows voxels;
    std::uint32_t found = 0;
    if (load_voxels(object, bricks.coords[brick], voxels)) {
      NodeRows rows;
      OwnRows own;
      mark_face_centres(voxels, rows);
      dilate(rows, reach, own);
      for (const auto& plane : own)
        for (const std::uint16_t row : plane) found |= own_row(row);
    }
    used[brick] = found != 0;
  });
}

void TbbBackend::lattice_label(const BitView& object, int connectivity, const BrickView& bricks,
                               const std::array<int, 3>& radius, View<std::uint8_t> state) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    VoxelRows voxels;
    load_voxels(object, bricks.coords[brick], voxels);
    NodeRows centres, rows;
    OwnRows free;
    mark_face_centres(voxels, centres);
    std::memcpy(rows, centres, sizeof(rows));
    dilate(rows, radius, free);
    std::uint8_t* out = state.data() + kBrickCells * brick;
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y) {
        const std::uint32_t solid = solid_row(voxels, connectivity, y, z);
        const std::uint32_t free_row = own_row(free[z][y]);
        const std::uint32_t centre_row = own_row(centres[z + kNodeMargin][y + kNodeMargin]);
        const std::uint64_t states = bit_bytes(solid) * (kLabel | kSolid) |
                                     bit_bytes(free_row) * kFree |
                                     bit_bytes(centre_row) * kFaceCentre;
        std::memcpy(out + brick_cell(0, y, z), &states, sizeof(states));
      }
  });
}

void TbbBackend::lattice_sample(const BrickView& bricks, View<const std::int32_t> in_regular,
                                View<const float> regular, View<const std::int32_t> in_refined,
                                View<const float> refined, View<float> values) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    float* out = values.data() + kBrickCells * brick;
    const std::int32_t* fine = in_refined.data() + 27 * brick;
    if (refined_here(fine))
      sample_refined(fine, refined.data(), out);
    else
      sample_regular(in_regular.data() + 27 * brick, bricks.coords[brick], regular.data(), out);
  });
}

}  // namespace vasamesh

/// Counting and writing the samples of each brick.

#include "stages/points.h"

#include <bit>

#include "tbb/tbb_backend.h"
#include "types/row_bits.h"

namespace vasamesh {

namespace {

constexpr int kHalo = 2;                       // voxels round a brick that its points look at
constexpr int kSpan = kBrickSide + 2 * kHalo;  // 12
constexpr std::size_t kGrain = 16;             // bricks a task takes

/// A brick of bits with two voxels round it: voxel (x, y, z) of the brick is bit x + 2 of
/// row[z + 2][y + 2].
struct Block {
  unsigned row[kSpan][kSpan];

  Block(const BitView& bits, const BrickCoord& brick) {
    for (int z = 0; z < kSpan; ++z)
      for (int y = 0; y < kSpan; ++y) {
        const int vy = 8 * brick.y + y - kHalo, vz = 8 * brick.z + z - kHalo;
        const bool inside = vy >= 0 && vy < bits.size[1] && vz >= 0 && vz < bits.size[2];
        row[z][y] = inside ? row_bits(bits.words.data() + bits.row(vy, vz), bits.words_per_row,
                                      8 * brick.x - kHalo, kSpan)
                           : 0;
      }
  }

  bool test(int x, int y, int z) const { return row[z + kHalo][y + kHalo] >> (x + kHalo) & 1u; }

  bool empty() const {
    unsigned any = 0;
    for (const auto& slice : row)
      for (const unsigned bits : slice) any |= bits;
    return any == 0;
  }

  /// Set voxels of the 5 x 5 x 5 round (x, y, z).
  int count_near(int x, int y, int z) const {
    int count = 0;
    for (int dz = 0; dz < 5; ++dz)
      for (int dy = 0; dy < 5; ++dy) count += std::popcount(row[z + dz][y + dy] >> x & 0x1fu);
    return count;
  }

  /// The object neighbours of voxel (x, y, z).
  unsigned mask(int x, int y, int z) const {
    return unsigned{test(x - 1, y, z)} | unsigned{test(x + 1, y, z)} << 1 |
           unsigned{test(x, y - 1, z)} << 2 | unsigned{test(x, y + 1, z)} << 3 |
           unsigned{test(x, y, z - 1)} << 4 | unsigned{test(x, y, z + 1)} << 5;
  }

  /// body(x, y, z) for each outer boundary voxel of the brick, in order.
  template <class Body>
  void for_each_boundary_voxel(const Body& body) const {
    for (int z = 0; z < kBrickSide; ++z)
      for (int y = 0; y < kBrickSide; ++y) {
        const unsigned* own = &row[z + kHalo][y + kHalo];
        const unsigned near =
            own[0] << 1 | own[0] >> 1 | own[-1] | own[1] | own[-kSpan] | own[kSpan];
        unsigned boundary = (near & ~own[0]) >> kHalo & 0xffu;
        for (; boundary != 0; boundary &= boundary - 1) body(std::countr_zero(boundary), y, z);
      }
  }
};

/// Writes the point of a cell (a voxel, or a subvoxel of half its size) from its shared faces.
struct Emitter {
  const PointOutput& out;
  std::array<float, 3> face_area;
  std::size_t next = 0;

  /// \param side  the cell's corner in the voxel, in halves; 0 for a whole voxel.
  void emit(const std::array<int, 3>& voxel, const std::array<int, 3>& side, float size,
            unsigned mask, float thickness) {
    const int faces = std::popcount(mask);
    for (int axis = 0; axis < 3; ++axis) {
      const int below = mask >> (2 * axis) & 1u, above = mask >> (2 * axis + 1) & 1u;
      // centres of the faces, in halves of the cell: 0 below, 2 above, 1 on the other axes
      const int sum = faces - below + above;
      const float mean = static_cast<float>(sum) / static_cast<float>(2 * faces);
      const float corner = 0.5f * static_cast<float>(side[axis]);
      out.position[axis][next] = static_cast<float>(voxel[axis]) + (corner + size * mean);
      // outward is from object to background: up when the object is below
      out.area[axis][next] = (size * size) * (face_area[axis] * static_cast<float>(below - above));
    }
    out.thickness[next] = thickness;
    ++next;
  }

  void emit_voxel(const std::array<int, 3>& voxel, unsigned mask, bool refined, float thickness) {
    if (refined) {
      for (int s = 0; s < 8; ++s)
        if (const unsigned part = subvoxel_mask(mask, s))
          emit(voxel, {s & 1, s >> 1 & 1, s >> 2}, 0.5f, part, thickness);
    } else if (has_opposite_pair(mask)) {
      for (; mask != 0; mask &= mask - 1) emit(voxel, {0, 0, 0}, 1.0f, mask & -mask, thickness);
    } else {
      emit(voxel, {0, 0, 0}, 1.0f, mask, thickness);
    }
  }
};

/// 1 - thin part of the object round a voxel.
float local_thickness(const Block& object, const Block& thin, int x, int y, int z) {
  const int all = object.count_near(x, y, z);
  if (all == 0) return 0;
  return 1.0f - static_cast<float>(thin.count_near(x, y, z)) / static_cast<float>(all);
}

}  // namespace

void TbbBackend::points_count(const BitView& object, const BitView& refine, const BrickView& bricks,
                              View<std::uint32_t> counts, View<std::uint32_t> refined) {
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    const Block block(object, bricks.coords[brick]);
    const Block fine(refine, bricks.coords[brick]);
    std::uint32_t* out = counts.data() + brick * kBrickCells;
    std::fill_n(out, kBrickCells, 0u);
    std::uint32_t from_refined = 0;
    block.for_each_boundary_voxel([&](int x, int y, int z) {
      const bool split = fine.test(x, y, z);
      const std::uint32_t count = kPointCounts[split][block.mask(x, y, z)];
      out[brick_cell(x, y, z)] = count;
      if (split) from_refined += count;
    });
    refined[brick] = from_refined;
  });
}

void TbbBackend::points_emit(const BitView& object, const BitView& thin, const BitView& refine,
                             const BrickView& bricks, View<const std::uint32_t> voxel_start,
                             const Scale& scale, const PointOutput& points) {
  const std::array<float, 3> face_area{scale[1] * scale[2], scale[0] * scale[2],
                                       scale[0] * scale[1]};
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    const BrickCoord at = bricks.coords[brick];
    const Block block(object, at), fine(refine, at), slender(thin, at);
    const bool any_thin = !slender.empty();
    Emitter emitter{points, face_area, voxel_start[brick * kBrickCells]};
    block.for_each_boundary_voxel([&](int x, int y, int z) {
      const float thickness = any_thin ? local_thickness(block, slender, x, y, z) : 1.0f;
      emitter.emit_voxel({8 * at.x + x, 8 * at.y + y, 8 * at.z + z}, block.mask(x, y, z),
                         fine.test(x, y, z), thickness);
    });
  });
}

}  // namespace vasamesh

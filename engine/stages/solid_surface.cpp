#include "stages/solid_surface.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "types/lattice_access.h"
#include "types/marching_cube.h"
#include "types/row_bits.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 64;  // bricks a task takes
constexpr std::size_t kWords = kBrickCells / 64;

/// The numbers of the face centres, by their nodes.
class FaceNumbers {
 public:
  FaceNumbers(Backend& backend, View<const std::uint8_t> state)
      : words_(filled_in_steps<std::uint64_t>(backend, state.size / 64)),
        first_(filled_in_steps<std::uint32_t>(backend, state.size / 64 + 1)) {
    for_each_index(backend, words_.size(), kGrain * kWords, [&](std::size_t w) {
      for (std::size_t eight = 0; eight < 8; ++eight)
        words_[w] |= std::uint64_t{face_bits(state.data() + 64 * w + 8 * eight)} << 8 * eight;
    });
    in_steps(backend, words_.size(), [&](std::size_t w) {
      first_[w + 1] = first_[w] + static_cast<std::uint32_t>(std::popcount(words_[w]));
    });
  }

  std::size_t count() const { return first_.back(); }
  std::uint32_t at(std::size_t node) const {
    const std::uint64_t below = (std::uint64_t{1} << node % 64) - 1;
    return first_[node / 64] + static_cast<std::uint32_t>(std::popcount(words_[node / 64] & below));
  }

  /// Row (y, z) of a brick's face centres, bit x.
  std::uint32_t row(std::size_t brick, int y, int z) const {
    return static_cast<std::uint32_t>(
        words_[brick * kWords + static_cast<std::size_t>(z)] >> 8 * y & 0xffu);
  }

  /// visit(node) for a brick's face centres.
  template <class Visit>
  void for_each_in(std::size_t brick, const Visit& visit) const {
    for (std::size_t w = brick * kWords; w < (brick + 1) * kWords; ++w)
      for (std::uint64_t rest = words_[w]; rest; rest &= rest - 1)
        visit(64 * w + static_cast<std::size_t>(std::countr_zero(rest)));
  }

 private:
  /// Bit i is set where node i of eight is a face centre.
  static std::uint32_t face_bits(const std::uint8_t* states) {
    std::uint64_t eight;
    std::memcpy(&eight, states, sizeof eight);
    return gather_bits(eight / kFaceCentre);
  }

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> first_;
};

/// The lattice corners of a brick that have face centres beside them.
class CornersNear {
 public:
  /// \param near  the brick's entries of the neighbour table.
  CornersNear(const FaceNumbers& faces, const std::int32_t* near) {
    const auto row = [&](int dx, int y, int z) {
      const std::int32_t brick = near[brick_neighbour(dx, y >> 3, z >> 3)];
      return brick == kNoBrick ? 0u : faces.row(static_cast<std::size_t>(brick), y & 7, z & 7);
    };
    for (int z = -1; z < 8; ++z)
      for (int y = -1; y < 8; ++y) rows_[z + 1][y + 1] = row(-1, y, z) >> 7 | row(0, y, z) << 1;
  }

  bool has(int x, int y, int z) const {
    std::uint32_t any = 0;
    for (int k = z; k < z + 3; ++k)
      for (int j = y; j < y + 3; ++j) any |= rows_[k][j];
    return (any >> x & 7) != 0;
  }

 private:
  std::uint32_t rows_[9][9];  // z, y from -1; bit x + 1
};

/// Whether the corners of a polygon (of kCubeFaces) lie in a plane, whatever the spacings.
bool is_plane(const std::array<int, 12>& polygon, int size) {
  const auto corner = [&](int k) {
    return kCubeFaces[static_cast<std::size_t>(polygon[static_cast<std::size_t>(k)])];
  };
  const auto from_first = [&](int k) {
    const NodeOffset a = corner(0), b = corner(k);
    return std::array{b.x - a.x, b.y - a.y, b.z - a.z};
  };
  const auto [ax, ay, az] = from_first(1);
  const auto [bx, by, bz] = from_first(2);
  const int nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
  for (int k = 3; k < size; ++k) {
    const auto [cx, cy, cz] = from_first(k);
    if (nx * cx + ny * cy + nz * cz != 0) return false;
  }
  return true;
}

/// The triangles of some bricks.
struct Part {
  std::vector<std::uint32_t> all, common;
};

/// Adds a polygon, given by its corners' numbers.
void add_polygon(std::span<const std::uint32_t> corners, bool plane, Part& part) {
  const std::size_t size = corners.size();
  if (plane) {
    for (std::size_t k = 2; k < size; ++k)
      for (std::vector<std::uint32_t>* to : {&part.all, &part.common})
        to->insert(to->end(), {corners[0], corners[k - 1], corners[k]});
    return;
  }
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint32_t next = corners[(i + 1) % size];
    part.common.insert(part.common.end(), {corners[i], next, next});
    for (std::size_t j = i + 1; j < size; ++j)
      for (std::size_t k = j + 1; k < size; ++k)
        part.all.insert(part.all.end(), {corners[i], corners[j], corners[k]});
  }
}

/// The polygons of the cubes round a brick's lattice corners.
void add_polygons(const BrickView& bricks, View<const std::uint8_t> state, std::size_t brick,
                  const FaceNumbers& faces, Part& part) {
  const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
  const CornersNear corners_near(faces, near);
  for (int corner = 0; corner < 64; ++corner) {
    const int x = 2 * (corner & 3), y = 2 * (corner >> 2 & 3), z = 2 * (corner >> 4);
    if (!corners_near.has(x, y, z)) continue;
    const auto node = [&](NodeOffset o) { return node_at(near, x + o.x, y + o.y, z + o.z); };
    const MarchingCube cube([&](NodeOffset o) {
      const std::size_t at = node(o);
      return at == kNoNode ? std::uint8_t{0} : state[at];
    });
    cube.for_each_polygon([&](const std::array<int, 12>& polygon, int size) {
      std::array<std::uint32_t, 12> corners{};
      for (std::size_t k = 0; k < static_cast<std::size_t>(size); ++k)
        corners[k] = faces.at(node(kCubeFaces[static_cast<std::size_t>(polygon[k])]));
      add_polygon(std::span(corners).first(static_cast<std::size_t>(size)), is_plane(polygon, size),
                  part);
    });
  }
}

}  // namespace

SolidSurface marching_cubes_of(Backend& backend, const Lattice& lattice, const Scale& scale) {
  const BrickView bricks = lattice.bricks.view();
  const auto state = lattice.state.view();
  const FaceNumbers faces(backend, state);
  SolidSurface surface;
  std::vector<float>& vertices = surface.all.vertices;
  resize_in_steps(backend, 3 * faces.count(), vertices);
  const auto make = [&](std::size_t begin, std::size_t end) {
    Part part;
    for (std::size_t b = begin; b < end; ++b) {
      const BrickCoord& brick = bricks.coords[b];
      faces.for_each_in(b, [&](std::size_t node) {
        const int cell = static_cast<int>(node % kBrickCells);
        float* p = vertices.data() + 3 * std::size_t{faces.at(node)};
        p[0] = 0.5f * scale[0] * static_cast<float>(8 * brick.x + (cell & 7));
        p[1] = 0.5f * scale[1] * static_cast<float>(8 * brick.y + (cell >> 3 & 7));
        p[2] = 0.5f * scale[2] * static_cast<float>(8 * brick.z + (cell >> 6));
      });
      add_polygons(bricks, state, b, faces, part);
    }
    return part;
  };
  const std::vector<Part> parts = map_ranges(backend, bricks.count, kGrain, make);
  append_in_steps<float>(backend, vertices, surface.common.vertices);
  for (const Part& part : parts) {
    append_in_steps<std::uint32_t>(backend, part.all, surface.all.triangles);
    append_in_steps<std::uint32_t>(backend, part.common, surface.common.triangles);
  }
  return surface;
}

}  // namespace vasamesh

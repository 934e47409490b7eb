/// Where the labels leave the segmentation too far: its marching-cubes surface is known at the
/// centres of boundary faces (its vertices) and between those of one cube (its triangles).

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "stages/far_offsets.h"
#include "tbb/tbb_backend.h"
#include "types/lattice_access.h"
#include "types/marching_cube.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;      // bricks a task takes
using Position = std::array<float, 3>;  // nodes, from the brick's corner

/// The states of a brick's nodes and of those up to four away; kMissing where there is none.
struct StateHalo {
  static constexpr int kMargin = 4;
  static constexpr int kSide = 8 + 2 * kMargin;

  static constexpr int at(int x, int y, int z) {
    return (x + kMargin) + kSide * ((y + kMargin) + kSide * (z + kMargin));
  }

  StateHalo(const std::int32_t* near, const std::uint8_t* state) {
    for (int z = -kMargin; z < 8 + kMargin; ++z)
      for (int y = -kMargin; y < 8 + kMargin; ++y) {
        std::uint8_t* row = values + at(0, y, z);
        take(node_at(near, -kMargin, y, z), kMargin, state, row - kMargin);
        take(node_at(near, 0, y, z), 8, state, row);
        take(node_at(near, 8, y, z), kMargin, state, row + 8);
      }
  }

  /// The states of nodes in a row of a brick.
  static void take(std::size_t first, int count, const std::uint8_t* state, std::uint8_t* to) {
    if (first == kNoNode)
      std::fill_n(to, count, kMissing);
    else
      std::copy_n(state + first, count, to);
  }

  static constexpr std::uint8_t kMissing = 0x80;
  std::uint8_t values[kSide * kSide * kSide];
};

/// An offset at which the surface is looked for, and what it adds to an index of the halo.
struct NearOffset {
  FarOffset reach;
  int index;
};

/// The tests on one lattice; lengths in voxel lengths.
class FarTest {
 public:
  FarTest(const BrickView& bricks, const Scale& scale, float limit, const std::uint8_t* state,
          const float* values)
      : bricks_(bricks), scale_(scale), limit_(limit), state_(state), values_(values) {
    FarOffsets offsets = make_far_offsets(scale, limit);
    edge_length_ = offsets.edge_length;
    search_ = std::move(offsets.search);
    for (const FarOffset& o : offsets.beside)
      near_.push_back({o, StateHalo::at(o.x, o.y, o.z) - StateHalo::at(0, 0, 0)});
  }

  /// Marks the brick's nodes. \return how many are far.
  std::uint32_t mark(std::size_t brick, std::uint8_t* marks) const {
    const std::int32_t* near = bricks_.neighbours.data() + 27 * brick;
    const StateHalo halo(near, state_);
    std::uint32_t count = 0;
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const Node node = {
          near,     &halo,         kBrickCells * brick + static_cast<std::size_t>(cell),
          cell & 7, cell >> 3 & 7, cell >> 6};
      marks[cell] = is_far(node) ? kFarMark : 0;
      count += marks[cell] != 0;
    }
    return count;
  }

 private:
  struct Node {
    const std::int32_t* near;
    const StateHalo* halo;
    std::size_t index;
    int x, y, z;
  };

  /// The distances of points of one marching cube to the surface, looked up when first needed.
  class SurfaceNear {
   public:
    SurfaceNear(const FarTest& test, const Node& node, const std::array<bool, 12>& crossed)
        : test_(test), node_(node) {
      corner_ = test.surface_distance(node, 0.35f * test.limit_);
      for (std::size_t i = 0; i < 12; ++i) {
        const NodeOffset o = kCubeFaces[i];
        if (!crossed[i]) continue;
        const int x = node.x + o.x, y = node.y + o.y, z = node.z + o.z;
        const Node face = {node.near, node.halo, node_at(node.near, x, y, z), x, y, z};
        face_[i] = test.surface_distance(face, 0.35f * test.limit_);
      }
    }

    /// Whether the middle of `size` face centres (of kCubeFaces) is far from the surface.
    bool is_far(const std::array<int, 12>& faces, int size) {
      Position middle{};
      for (int k = 0; k < size; ++k) {
        const Position face = at(faces[static_cast<std::size_t>(k)]);
        for (std::size_t a = 0; a < 3; ++a) middle[a] += face[a] / static_cast<float>(size);
      }
      for (int k = 0; k < size; ++k) {
        const auto i = static_cast<std::size_t>(faces[static_cast<std::size_t>(k)]);
        if (face_[i] + std::sqrt(test_.square(at(static_cast<int>(i)), middle)) <= test_.limit_)
          return false;
      }
      const Position corner = {static_cast<float>(node_.x), static_cast<float>(node_.y),
                               static_cast<float>(node_.z)};
      if (corner_ + std::sqrt(test_.square(corner, middle)) <= test_.limit_) return false;
      return !crossing_near(middle);
    }

   private:
    /// Whether a crossing round the node lies within the limit of a point. No more of them are
    /// looked for than it takes.
    bool crossing_near(const Position& point) {
      std::size_t seen = 0;
      while (true) {
        for (; seen < crossings_.size(); ++seen)
          if (test_.square(crossings_[seen], point) <= test_.limit_ * test_.limit_) return true;
        if (searched_ == test_.search_.size()) return false;
        test_.add_crossings(node_, test_.search_[searched_++], crossings_);
      }
    }

    Position at(int face) const { return face_at(node_.x, node_.y, node_.z, face); }

    const FarTest& test_;
    const Node& node_;
    float corner_;                  // from the corner to the surface, from above
    std::array<float, 12> face_{};  // from the face centres
    std::vector<Position> crossings_;
    std::size_t searched_ = 0;  // of the offsets of the search
  };

  bool is_far(const Node& node) const {
    const std::uint8_t own = state_[node.index];
    if (own & kFaceCentre) return surface_distance(node, limit_) > limit_;
    if (!((node.x | node.y | node.z) & 1) && cube_is_far(node)) return true;
    // A relabelled node: the crossings of its edges. Only such nodes have far ones.
    return (own & kLabel) != (own >> 1 & 1) && crossings_are_far(node);
  }

  float square(const Position& a, const Position& b) const {
    const float dx = 0.5f * scale_[0] * (a[0] - b[0]), dy = 0.5f * scale_[1] * (a[1] - b[1]),
                dz = 0.5f * scale_[2] * (a[2] - b[2]);
    return (dx * dx + dy * dy) + dz * dz;
  }

  bool differ(std::size_t a, std::size_t b) const {
    return ((state_[a] ^ state_[b]) & kLabel) != 0;
  }

  /// How far along an edge from a to b the surface crosses it, 0 to 1.
  float crossing(std::size_t a, std::size_t b) const {
    const float own = std::fabs(values_[a]), other = std::fabs(values_[b]);
    return own + other > 0 ? own / (own + other) : 0.5f;
  }

  /// A bound from above of a node's distance to the surface: to where it crosses an edge of the
  /// node, or to a node of another label, the nearest of all; more than the limit where there is
  /// none. Any bound up to `enough` will do.
  float surface_distance(const Node& node, float enough) const {
    const std::uint8_t* own = node.halo->values + StateHalo::at(node.x, node.y, node.z);
    float best = 2 * limit_;
    for (const NearOffset& offset : near_) {
      const std::uint8_t other = own[offset.index];
      if (!((other ^ *own) & kLabel) || (other & StateHalo::kMissing)) continue;
      const FarOffset& o = offset.reach;
      float distance = o.length;
      if (o.edge) {
        const std::size_t end = node_at(node.near, node.x + o.x, node.y + o.y, node.z + o.z);
        distance *= crossing(node.index, end);
      }
      best = std::min(best, distance);
      if (best <= enough) break;
    }
    return best;
  }

  bool crossings_are_far(const Node& node) const {
    for (std::size_t i = 0; i < kLink.size(); ++i) {
      const NodeOffset o = kLink[i];
      const std::size_t other = node_at(node.near, node.x + o.x, node.y + o.y, node.z + o.z);
      if (other == kNoNode || !differ(node.index, other) || (state_[other] & kFaceCentre)) continue;
      const float t = crossing(node.index, other);
      const Position point = {static_cast<float>(node.x) + t * static_cast<float>(o.x),
                              static_cast<float>(node.y) + t * static_cast<float>(o.y),
                              static_cast<float>(node.z) + t * static_cast<float>(o.z)};
      if (!face_centre_near(node, point, edge_length_[i % 7]) && !side_near(node, point))
        return true;
    }
    return false;
  }

  /// Whether a face centre lies within the limit of a point at most `away` from the node.
  bool face_centre_near(const Node& node, const Position& point, float away) const {
    for (const FarOffset& o : search_) {
      if (o.length > limit_ + away) return false;
      const int x = node.x + o.x, y = node.y + o.y, z = node.z + o.z;
      const std::size_t other = node_at(node.near, x, y, z);
      if (other == kNoNode || !(state_[other] & kFaceCentre)) continue;
      const Position centre = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
      if (square(centre, point) <= limit_ * limit_) return true;
    }
    return false;
  }

  static MarchingCube cube_round(const StateHalo& halo, int x, int y, int z) {
    return MarchingCube(
        [&](NodeOffset o) { return halo.values[StateHalo::at(x + o.x, y + o.y, z + o.z)]; });
  }

  /// Whether a side of a marching cube's polygons lies within the limit of a point.
  bool side_near(const Node& node, const Position& point) const {
    std::array<int, 3> corner;
    for (std::size_t a = 0; a < 3; ++a)
      corner[a] = 2 * static_cast<int>(std::floor(0.5f * point[a] + 0.5f));
    for (int k = 0; k < 27; ++k) {
      const int x = corner[0] + 2 * (k % 3 - 1), y = corner[1] + 2 * (k / 3 % 3 - 1),
                z = corner[2] + 2 * (k / 9 - 1);
      const MarchingCube cube = cube_round(*node.halo, x, y, z);
      for (std::size_t s = 0; s < cube.side_count; ++s)
        if (square_to_segment(point, face_at(x, y, z, cube.sides[s][0]),
                              face_at(x, y, z, cube.sides[s][1])) <= limit_ * limit_)
          return true;
    }
    return false;
  }

  static Position face_at(int x, int y, int z, int i) {
    const NodeOffset o = kCubeFaces[static_cast<std::size_t>(i)];
    return {static_cast<float>(x + o.x), static_cast<float>(y + o.y), static_cast<float>(z + o.z)};
  }

  float square_to_segment(const Position& p, const Position& a, const Position& b) const {
    float along = 0, length = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const float step = 0.5f * scale_[i];
      along += step * (p[i] - a[i]) * (step * (b[i] - a[i]));
      length += step * (b[i] - a[i]) * (step * (b[i] - a[i]));
    }
    const float t = std::clamp(along / length, 0.0f, 1.0f);
    Position nearest;
    for (std::size_t i = 0; i < 3; ++i) nearest[i] = a[i] + t * (b[i] - a[i]);
    return square(p, nearest);
  }

  /// Whether a polygon of the marching cube round a corner is far from the surface, in its middle
  /// or between two of its corners.
  bool cube_is_far(const Node& node) const {
    const MarchingCube cube = cube_round(*node.halo, node.x, node.y, node.z);
    if (cube.count < 3) return false;
    SurfaceNear surface(*this, node, cube.crossed);
    bool far = false;
    cube.for_each_polygon([&](const std::array<int, 12>& polygon, int size) {
      far = far || polygon_is_far(polygon, size, surface);
    });
    return far;
  }

  static bool polygon_is_far(const std::array<int, 12>& polygon, int size, SurfaceNear& surface) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        if (surface.is_far({polygon[i], polygon[j]}, 2)) return true;
        for (std::size_t k = 0; k < j; ++k)
          if (surface.is_far({polygon[i], polygon[j], polygon[k]}, 3)) return true;
      }
    return false;
  }

  /// Where the surface crosses the edges of the node at an offset from another.
  void add_crossings(const Node& node, const FarOffset& reach, std::vector<Position>& found) const {
    const int x = node.x + reach.x, y = node.y + reach.y, z = node.z + reach.z;
    if (std::min({x, y, z}) < -7 || std::max({x, y, z}) > 14) return;
    const std::size_t own = node_at(node.near, x, y, z);
    if (own == kNoNode) return;
    for (std::size_t d = 0; d < 7; ++d) {
      const NodeOffset o = kLink[d];
      const std::size_t other = node_at(node.near, x + o.x, y + o.y, z + o.z);
      if (other == kNoNode || !differ(own, other)) continue;
      const float t = crossing(own, other);
      found.push_back({static_cast<float>(x) + t * static_cast<float>(o.x),
                       static_cast<float>(y) + t * static_cast<float>(o.y),
                       static_cast<float>(z) + t * static_cast<float>(o.z)});
    }
  }

  BrickView bricks_;
  Scale scale_;
  float limit_;
  const std::uint8_t* state_;
  const float* values_;
  std::array<float, 7> edge_length_{};  ///< along bit masks 1..7
  std::vector<FarOffset> search_;       ///< for crossings and faces
  std::vector<NearOffset> near_;        ///< for the surface near a node
};

}  // namespace

std::uint32_t TbbBackend::lattice_mark_far(const BrickView& bricks, View<const std::uint8_t> active,
                                           const Scale& scale, float limit,
                                           View<const std::uint8_t> state, View<const float> values,
                                           View<std::uint8_t> marks) {
  const FarTest test(bricks, scale, limit, state.data(), values.data());
  std::atomic<std::uint32_t> total{0};
  fill(marks, std::uint8_t{0});
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    if (!active[brick]) return;
    total += test.mark(brick, marks.data() + kBrickCells * brick);
  });
  return total;
}

}  // namespace vasamesh

/// Where the labels leave the segmentation too far: its marching-cubes surface is known at the
/// centres of boundary faces (its vertices) and between those of one cube (its triangles).

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include "tbb/lattice_access.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;  // bricks a task takes
constexpr int kFarReach = 6;        // nodes searched along each axis

/// An offset in nodes and its length in voxel lengths.
struct Reach {
  int x, y, z;
  float length;
};

using Position = std::array<float, 3>;  // nodes, from the brick's corner

/// The twelve edges of a marching cube round a lattice corner: the faces between its voxels.
constexpr std::array<NodeOffset, 12> kCubeFaces = {{{0, -1, -1},
                                                    {0, 1, -1},
                                                    {0, -1, 1},
                                                    {0, 1, 1},
                                                    {-1, 0, -1},
                                                    {1, 0, -1},
                                                    {-1, 0, 1},
                                                    {1, 0, 1},
                                                    {-1, -1, 0},
                                                    {1, -1, 0},
                                                    {-1, 1, 0},
                                                    {1, 1, 0}}};

/// The tests on one lattice; lengths in voxel lengths.
class FarTest {
 public:
  FarTest(const BrickView& bricks, const Scale& scale, float limit, const std::uint8_t* state,
          const float* values)
      : bricks_(bricks), scale_(scale), limit_(limit), state_(state), values_(values) {
    float longest = 0;
    for (int d = 1; d < 8; ++d) {
      const NodeOffset o = kLink[static_cast<std::size_t>(d - 1)];
      edge_length_[static_cast<std::size_t>(d)] = length(o.x, o.y, o.z);
      longest = std::max(longest, edge_length_[static_cast<std::size_t>(d)]);
    }
    search_ = offsets_within(limit + longest);
  }

  bool is_far(std::size_t brick, int cell) const {
    const Node node = {bricks_.neighbours.data() + 27 * brick, kBrickCells * brick + cell, cell & 7,
                       cell >> 3 & 7, cell >> 6};
    const std::uint8_t own = state_[node.index];
    if (own & kFaceCentre) return !surface_near(node, limit_);
    if (!((node.x | node.y | node.z) & 1) && cube_is_far(node)) return true;
    // A relabelled node: the crossings of its edges. Only such nodes have far ones.
    return (own & kLabel) != (own >> 1 & 1) && crossings_are_far(node);
  }

 private:
  struct Node {
    const std::int32_t* near;
    std::size_t index;
    int x, y, z;
  };

  float length(int x, int y, int z) const {
    const float dx = 0.5f * scale_[0] * static_cast<float>(x),
                dy = 0.5f * scale_[1] * static_cast<float>(y),
                dz = 0.5f * scale_[2] * static_cast<float>(z);
    return std::sqrt((dx * dx + dy * dy) + dz * dz);
  }

  float square(const Position& a, const Position& b) const {
    const float dx = 0.5f * scale_[0] * (a[0] - b[0]), dy = 0.5f * scale_[1] * (a[1] - b[1]),
                dz = 0.5f * scale_[2] * (a[2] - b[2]);
    return (dx * dx + dy * dy) + dz * dz;
  }

  /// Offsets of at most `most`, shortest first; ties in raster order.
  std::vector<Reach> offsets_within(float most) const {
    std::vector<Reach> offsets;
    for (int z = -kFarReach; z <= kFarReach; ++z)
      for (int y = -kFarReach; y <= kFarReach; ++y)
        for (int x = -kFarReach; x <= kFarReach; ++x)
          if (const float l = length(x, y, z); l <= most) offsets.push_back({x, y, z, l});
    std::stable_sort(offsets.begin(), offsets.end(),
                     [](const Reach& a, const Reach& b) { return a.length < b.length; });
    return offsets;
  }

  bool differ(std::size_t a, std::size_t b) const {
    return ((state_[a] ^ state_[b]) & kLabel) != 0;
  }

  /// How far along an edge from a to b the surface crosses it, 0 to 1.
  float crossing(std::size_t a, std::size_t b) const {
    const float own = std::fabs(values_[a]), other = std::fabs(values_[b]);
    return own + other > 0 ? own / (own + other) : 0.5f;
  }

  /// Whether the surface passes within `most` of a node: it crosses an edge of the node there, or
  /// lies before a node there that has another label.
  bool surface_near(const Node& node, float most) const {
    for (const Reach& o : search_) {
      const std::size_t other = node_at(node.near, node.x + o.x, node.y + o.y, node.z + o.z);
      if (other == kNoNode || !differ(node.index, other)) continue;
      const int low = std::min({o.x, o.y, o.z}), high = std::max({o.x, o.y, o.z});
      const bool edge = (low >= 0 && high == 1) || (high <= 0 && low == -1);
      if (o.length * (edge ? crossing(node.index, other) : 1.0f) <= most) return true;
    }
    return false;
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
      if (!face_centre_near(node, point, edge_length_[i % 7 + 1])) return true;
    }
    return false;
  }

  /// Whether a face centre lies within the limit of a point at most `away` from the node.
  bool face_centre_near(const Node& node, const Position& point, float away) const {
    for (const Reach& o : search_) {
      if (o.length > limit_ + away) return false;
      const int x = node.x + o.x, y = node.y + o.y, z = node.z + o.z;
      const std::size_t other = node_at(node.near, x, y, z);
      if (other == kNoNode || !(state_[other] & kFaceCentre)) continue;
      const Position centre = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
      if (square(centre, point) <= limit_ * limit_) return true;
    }
    return false;
  }

  /// Whether the middle between two boundary faces of the marching cube round a corner is far from
  /// the surface: there the cube's triangles may lie.
  bool cube_is_far(const Node& node) const {
    std::array<Position, 12> faces;
    std::size_t count = 0;
    for (const NodeOffset& o : kCubeFaces) {
      const int x = node.x + o.x, y = node.y + o.y, z = node.z + o.z;
      const std::size_t other = node_at(node.near, x, y, z);
      if (other != kNoNode && (state_[other] & kFaceCentre))
        faces[count++] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    }
    if (count < 2 || surface_near(node, 0.5f * limit_)) return false;
    const std::vector<Position> surface = crossings_round(node);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Position middle;
        for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5f * (faces[i][k] + faces[j][k]);
        const bool near = std::any_of(surface.begin(), surface.end(), [&](const Position& p) {
          return square(p, middle) <= limit_ * limit_;
        });
        if (!near) return true;
      }
    return false;
  }

  /// Where the surface crosses the edges of the nodes near a node.
  std::vector<Position> crossings_round(const Node& node) const {
    std::vector<Position> found;
    for (const Reach& reach : search_) {
      const int x = node.x + reach.x, y = node.y + reach.y, z = node.z + reach.z;
      if (std::min({x, y, z}) < -7 || std::max({x, y, z}) > 14) continue;
      const std::size_t own = node_at(node.near, x, y, z);
      if (own == kNoNode) continue;
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
    return found;
  }

  BrickView bricks_;
  Scale scale_;
  float limit_;
  const std::uint8_t* state_;
  const float* values_;
  std::array<float, 8> edge_length_{};
  std::vector<Reach> search_;
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
    std::uint32_t count = 0;
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const bool far = test.is_far(brick, cell);
      marks[kBrickCells * brick + cell] = far;
      count += far;
    }
    total += count;
  });
  return total;
}

}  // namespace vasamesh

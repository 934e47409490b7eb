/// Where the labels leave the segmentation too far: its marching-cubes surface is known at the
/// centres of boundary faces (its vertices) and between those of one cube (its triangles).

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "stages/far_cubes.h"
#include "stages/far_offsets.h"
#include "tbb/byte_rows.h"
#include "tbb/far_halo.h"
#include "tbb/tbb_backend.h"
#include "types/lattice_access.h"
#include "types/marching_cube.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;      // bricks a task takes
using Position = std::array<float, 3>;  // nodes, from the brick's corner

/// A brick that is tested.
struct Place {
  const std::int32_t* near;
  StateHalo halo;
};

/// Where the surface crosses edges round a cube's corner, looked for as far as it is needed.
struct Crossings {
  std::vector<Position> found;
  std::size_t searched = 0;  ///< of the offsets of the search
};

/// The tests on one lattice; lengths in voxel lengths.
class FarTest {
 public:
  FarTest(const BrickView& bricks, const Scale& scale, float limit, const std::uint8_t* state,
          const float* values)
      : bricks_(bricks),
        scale_(scale),
        limit_(limit),
        state_(state),
        values_(values),
        offsets_(make_far_offsets(scale, limit)),
        parts_(make_far_parts(scale)),
        cubes_(far_cubes()) {
    for (const FarOffset& o : offsets_.beside) beside_index_.push_back(halo_step(o));
    for (const FarOffset& o : offsets_.search) {
      if (std::max({std::abs(o.x), std::abs(o.y), std::abs(o.z)}) > StateHalo::kMargin) break;
      search_index_.push_back(halo_step(o));
    }
  }

  /// Marks the nodes of some octants of a brick. \return how many are far.
  std::uint32_t mark(std::size_t brick, std::uint32_t octants, std::uint8_t* marks) const {
    const std::int32_t* near = bricks_.neighbours.data() + 27 * brick;
    const Place place = {near, StateHalo(near, state_)};
    FacesNear faces;
    measure_faces(place, octants, faces);
    Crossings crossings;
    std::fill_n(marks, kBrickCells, std::uint8_t{0});
    std::uint32_t count = 0;
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y) {
        const auto set = [&](int x, bool far) {
          std::uint8_t& mark = marks[brick_cell(x, y, z)];
          count += far && mark == 0;
          if (far) mark = kFarMark;
        };
        const std::uint8_t* row = place.halo.values + StateHalo::at(0, y, z);
        const std::uint32_t asked = octant_row(octants, y, z);
        if (asked == 0) continue;
        const std::uint32_t centres = byte_bits(load_bytes(row), kFaceCentre);
        for_each_bit(centres & asked,
                     [&](int x) { set(x, faces.distance[FacesNear::at(x, y, z)] > limit_); });
        if (!((y | z) & 1))
          for (int x = 0; x < 8; x += 2)
            if (asked >> x & 1) set(x, cube_is_far(place, faces, {x, y, z}, crossings));
        // The crossings of relabelled nodes' edges. Only such nodes have far ones.
        const std::uint32_t relabelled =
            byte_bits(load_bytes(row), kLabel) ^ byte_bits(load_bytes(row), kSolid);
        for_each_bit(relabelled & ~centres & asked, [&](int x) {
          if (marks[brick_cell(x, y, z)] == 0) set(x, crossings_are_far(place, {x, y, z}));
        });
      }
    return count;
  }

 private:
  float square(const Position& a, const Position& b) const {
    const float dx = 0.5f * scale_[0] * (a[0] - b[0]), dy = 0.5f * scale_[1] * (a[1] - b[1]),
                dz = 0.5f * scale_[2] * (a[2] - b[2]);
    return (dx * dx + dy * dy) + dz * dz;
  }

  static Position position_of(const FarNode& node) {
    return {static_cast<float>(node.x), static_cast<float>(node.y), static_cast<float>(node.z)};
  }

  /// What an offset adds to an index of the halo.
  static int halo_step(const FarOffset& o) {
    return StateHalo::at(o.x, o.y, o.z) - StateHalo::at(0, 0, 0);
  }

  /// The state of a node at most seven from the brick; kMissing where there is none.
  std::uint8_t state_at(const Place& place, const FarNode& node) const {
    constexpr int kLeast = -StateHalo::kMargin, kMost = 7 + StateHalo::kMargin;
    if (std::min({node.x, node.y, node.z}) >= kLeast && std::max({node.x, node.y, node.z}) <= kMost)
      return place.halo.values[StateHalo::at(node.x, node.y, node.z)];
    const std::size_t index = node_at(place.near, node.x, node.y, node.z);
    return index == kNoNode ? StateHalo::kMissing : state_[index];
  }

  /// Whether the surface crosses the edge between nodes of two states.
  static bool differ(std::uint8_t a, std::uint8_t b) {
    return (a ^ b) & ~((a | b) / StateHalo::kMissing) & kLabel;
  }

  /// How far along the edge from a node the surface crosses it, 0 to 1.
  float crossing(const Place& place, const FarNode& a, const FarNode& b) const {
    const float own = std::fabs(values_[node_at(place.near, a.x, a.y, a.z)]),
                other = std::fabs(values_[node_at(place.near, b.x, b.y, b.z)]);
    return own + other > 0 ? own / (own + other) : 0.5f;
  }

  /// A bound from above of a node's distance to the surface: to where it crosses an edge of the
  /// node, or to a node of another label, the nearest of all; more than the limit where there is
  /// none. Any bound up to kFarEnough limits will do.
  float surface_distance(const Place& place, const FarNode& node) const {
    constexpr std::size_t kAtOnce = 32;
    const std::uint8_t* own = place.halo.values + StateHalo::at(node.x, node.y, node.z);
    float best = 2 * limit_;
    for (std::size_t first = 0; first < beside_index_.size(); first += kAtOnce) {
      const std::size_t count = std::min(kAtOnce, beside_index_.size() - first);
      std::uint32_t others = 0;
      for (std::size_t i = 0; i < count; ++i)
        others |= std::uint32_t{differ(*own, own[beside_index_[first + i]])} << i;
      for (; others; others &= others - 1) {
        const FarOffset& o =
            offsets_.beside[first + static_cast<std::size_t>(std::countr_zero(others))];
        float distance = o.length;
        if (o.edge) distance *= crossing(place, node, {node.x + o.x, node.y + o.y, node.z + o.z});
        best = std::min(best, distance);
        if (best <= kFarEnough * limit_) return best;
      }
    }
    return best;
  }

  void measure_faces(const Place& place, std::uint32_t octants, FacesNear& faces) const {
    for (int z = -1; z < 8; ++z)
      for (int y = -1; y < 8; ++y) {
        const std::uint8_t* row = place.halo.values + StateHalo::at(0, y, z);
        const std::uint32_t wanted = beside_octants(octants, y, z);
        std::uint32_t bits = 0;
        const auto take = [&](int x) {
          bits |= 1u << (x + 1);
          if (wanted >> (x + 1) & 1)
            faces.distance[FacesNear::at(x, y, z)] = surface_distance(place, {x, y, z});
        };
        if (row[-1] & kFaceCentre) take(-1);
        for_each_bit(byte_bits(load_bytes(row), kFaceCentre), take);
        faces.rows[z + 1][y + 1] = bits;
      }
  }

  /// The marching cube round a corner.
  const FarCube& cube_round(const Place& place, const FarNode& corner) const {
    const std::uint8_t* own = place.halo.values + StateHalo::at(corner.x, corner.y, corner.z);
    std::size_t voxels = 0;
    for (int v = 0; v < 8; ++v) {
      constexpr int kOrigin = StateHalo::at(0, 0, 0);
      const int to = StateHalo::at(v & 1 ? 1 : -1, v & 2 ? 1 : -1, v & 4 ? 1 : -1) - kOrigin;
      voxels |= static_cast<std::size_t>((own[to] & kSolid) != 0) << v;
    }
    return cubes_.cubes[voxels];
  }

  /// Whether a polygon of the marching cube round a corner is far from the surface, in its middle
  /// or between two of its corners. Faces that do not count any more take no part.
  bool cube_is_far(const Place& place, const FacesNear& faces, const FarNode& corner,
                   Crossings& crossings) const {
    const std::uint32_t crossed = faces.crossed(corner);
    if (std::popcount(crossed) < 3) return false;
    std::array<float, 12> from_face;
    for (std::size_t i = 0; i < 12; ++i) {
      const NodeOffset o = kCubeFaces[i];
      from_face[i] =
          crossed >> i & 1
              ? faces.distance[FacesNear::at(corner.x + o.x, corner.y + o.y, corner.z + o.z)]
              : 0;
    }
    const FarCube& cube = cube_round(place, corner);
    float from_corner = -1;  // not looked for
    crossings.found.clear();
    crossings.searched = 0;
    for (std::int32_t p = cube.first_part; p < cube.last_part; ++p) {
      const FarPart& part = parts_[cubes_.parts[static_cast<std::size_t>(p)]];
      if (!takes_part(part, crossed) || face_is_near(part, from_face)) continue;
      if (from_corner < 0) from_corner = surface_distance(place, corner);
      if (from_corner + part.from_corner <= limit_) continue;
      Position middle = position_of(corner);
      for (std::size_t a = 0; a < 3; ++a) middle[a] += part.middle[a];
      if (!crossing_near(place, corner, middle, crossings)) return true;
    }
    return false;
  }

  static bool takes_part(const FarPart& part, std::uint32_t crossed) {
    bool all = true;
    for (std::size_t k = 0; k < static_cast<std::size_t>(part.count); ++k)
      all = all && (crossed >> part.face[k] & 1);
    return all;
  }

  /// Whether the surface near one of a part's faces is near its middle.
  bool face_is_near(const FarPart& part, const std::array<float, 12>& from_face) const {
    for (std::size_t k = 0; k < static_cast<std::size_t>(part.count); ++k)
      if (from_face[static_cast<std::size_t>(part.face[k])] + part.from_face[k] <= limit_)
        return true;
    return false;
  }

  /// Whether a crossing round a node lies within the limit of a point. No more of them are looked
  /// for than it takes.
  bool crossing_near(const Place& place, const FarNode& node, const Position& point,
                     Crossings& crossings) const {
    std::size_t seen = 0;
    while (true) {
      for (; seen < crossings.found.size(); ++seen)
        if (square(crossings.found[seen], point) <= limit_ * limit_) return true;
      if (crossings.searched == offsets_.search.size()) return false;
      const FarOffset& o = offsets_.search[crossings.searched++];
      add_crossings(place, {node.x + o.x, node.y + o.y, node.z + o.z}, crossings.found);
    }
  }

  /// Where the surface crosses the edges of a node.
  void add_crossings(const Place& place, const FarNode& node, std::vector<Position>& found) const {
    if (std::min({node.x, node.y, node.z}) < -7 || std::max({node.x, node.y, node.z}) > 14) return;
    const std::uint8_t own = state_at(place, node);
    for (std::size_t d = 0; d < 7; ++d) {
      const NodeOffset o = kLink[d];
      const FarNode other = {node.x + o.x, node.y + o.y, node.z + o.z};
      if (differ(own, state_at(place, other)))
        found.push_back(point_on(node, o, crossing(place, node, other)));
    }
  }

  static Position point_on(const FarNode& node, NodeOffset o, float t) {
    return {static_cast<float>(node.x) + t * static_cast<float>(o.x),
            static_cast<float>(node.y) + t * static_cast<float>(o.y),
            static_cast<float>(node.z) + t * static_cast<float>(o.z)};
  }

  bool crossings_are_far(const Place& place, const FarNode& node) const {
    const std::uint8_t* own = place.halo.values + StateHalo::at(node.x, node.y, node.z);
    for (std::size_t i = 0; i < kLink.size(); ++i) {
      const NodeOffset o = kLink[i];
      const std::uint8_t other = own[StateHalo::at(o.x, o.y, o.z) - StateHalo::at(0, 0, 0)];
      if (!differ(*own, other) || (other & kFaceCentre)) continue;
      const float t = crossing(place, node, {node.x + o.x, node.y + o.y, node.z + o.z});
      const Position point = point_on(node, o, t);
      if (!face_centre_near(place, node, point, offsets_.edge_length[i % 7]) &&
          !side_near(place, point))
        return true;
    }
    return false;
  }

  /// Whether a face centre lies within the limit of a point at most `away` from the node.
  bool face_centre_near(const Place& place, const FarNode& node, const Position& point,
                        float away) const {
    const std::uint8_t* own = place.halo.values + StateHalo::at(node.x, node.y, node.z);
    for (std::size_t i = 0; i < offsets_.search.size(); ++i) {
      const FarOffset& o = offsets_.search[i];
      if (o.length > limit_ + away) return false;
      const FarNode other = {node.x + o.x, node.y + o.y, node.z + o.z};
      const std::uint8_t state =
          i < search_index_.size() ? own[search_index_[i]] : state_at(place, other);
      if ((state & kFaceCentre) && square(position_of(other), point) <= limit_ * limit_)
        return true;
    }
    return false;
  }

  /// Whether a side of a marching cube's polygons lies within the limit of a point.
  bool side_near(const Place& place, const Position& point) const {
    std::array<int, 3> middle;
    for (std::size_t a = 0; a < 3; ++a)
      middle[a] = 2 * static_cast<int>(std::floor(0.5f * point[a] + 0.5f));
    for (int k = 0; k < 27; ++k) {
      const FarNode corner = {middle[0] + 2 * (k % 3 - 1), middle[1] + 2 * (k / 3 % 3 - 1),
                              middle[2] + 2 * (k / 9 - 1)};
      const FarCube& cube = cube_round(place, corner);
      for (std::int32_t s = cube.first_side; s < cube.last_side; ++s) {
        const std::uint16_t side = cubes_.sides[static_cast<std::size_t>(s)];
        const FarNode a = face_of(corner, side & 15), b = face_of(corner, side >> 4);
        if ((state_at(place, a) & state_at(place, b) & kFaceCentre) &&
            square_to_segment(point, position_of(a), position_of(b)) <= limit_ * limit_)
          return true;
      }
    }
    return false;
  }

  static FarNode face_of(const FarNode& corner, int face) {
    const NodeOffset o = kCubeFaces[static_cast<std::size_t>(face)];
    return {corner.x + o.x, corner.y + o.y, corner.z + o.z};
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

  BrickView bricks_;
  Scale scale_;
  float limit_;
  const std::uint8_t* state_;
  const float* values_;
  FarOffsets offsets_;
  std::vector<int> beside_index_;  ///< what they add to an index of the halo
  std::vector<int> search_index_;  ///< likewise, of those before the first that leaves the halo
  std::vector<FarPart> parts_;
  const FarCubes& cubes_;
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
    total += test.mark(brick, active[brick], marks.data() + kBrickCells * brick);
  });
  return total;
}

}  // namespace vasamesh

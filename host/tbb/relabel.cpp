/// Homotopic relabelling of the cell lattice and the local repair of its field.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include "tbb/lattice_access.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;       // bricks a task takes
constexpr std::size_t kNodeGrain = 512;  // listed nodes a task takes

bool wrong(std::uint8_t state, float value) { return ((state & kLabel) != 0) != (value > 0); }

/// The labels of a node's 14 neighbours; a missing one takes part as outside.
std::uint32_t link_labels(const BrickView& bricks, const std::uint8_t* state, std::size_t node) {
  const std::size_t brick = node / kBrickCells;
  const int cell = static_cast<int>(node % kBrickCells);
  const int x = cell & 7, y = cell >> 3 & 7, z = cell >> 6;
  const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
  std::uint32_t labels = 0;
  const bool inside = x > 0 && x < 7 && y > 0 && y < 7 && z > 0 && z < 7;
  for (std::size_t i = 0; i < kLink.size(); ++i) {
    const NodeOffset o = kLink[i];
    const std::size_t other = inside ? node + static_cast<std::ptrdiff_t>(brick_cell(o.x, o.y, o.z))
                                     : node_at(near, x + o.x, y + o.y, z + o.z);
    if (other != kNoNode) labels |= (state[other] & 1u) << i;
  }
  return labels;
}

template <class Visit>
void visit_colour(int colour, const Visit& visit) {
  for (int z = colour >> 2 & 1; z < 8; z += 2)
    for (int y = colour >> 1 & 1; y < 8; y += 2)
      for (int x = colour & 1; x < 8; x += 2) visit(brick_cell(x, y, z));
}

/// An offset in nodes and its length in voxel lengths.
struct Reach {
  int x, y, z;
  float length;
};

/// Offsets of at most `limit`, shortest first; ties in raster order.
std::vector<Reach> offsets_within(const Scale& scale, float limit, int most) {
  std::vector<Reach> offsets;
  for (int z = -most; z <= most; ++z)
    for (int y = -most; y <= most; ++y)
      for (int x = -most; x <= most; ++x) {
        const float dx = 0.5f * scale[0] * static_cast<float>(x),
                    dy = 0.5f * scale[1] * static_cast<float>(y),
                    dz = 0.5f * scale[2] * static_cast<float>(z);
        const float length = std::sqrt((dx * dx + dy * dy) + dz * dz);
        if (length <= limit) offsets.push_back({x, y, z, length});
      }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const Reach& a, const Reach& b) { return a.length < b.length; });
  return offsets;
}

constexpr int kFarReach = 6;  // nodes searched along each axis

/// Squared distance from a point (nodes from the brick's corner) to the nearest face centre among
/// the offsets round a node; more than the limit's square when there is none.
float nearest_face_centre(const std::int32_t* near, const std::uint8_t* state, const Scale& scale,
                          const std::vector<Reach>& offsets, const int (&node)[3],
                          const float (&point)[3], float edge_length) {
  float best = 1e30f;
  for (const Reach& o : offsets) {
    const float least = o.length - edge_length;
    if (least > 0 && least * least > best) break;
    const std::size_t other = node_at(near, node[0] + o.x, node[1] + o.y, node[2] + o.z);
    if (other == kNoNode || !(state[other] & kFaceCentre)) continue;
    const float dx = 0.5f * scale[0] * (static_cast<float>(node[0] + o.x) - point[0]),
                dy = 0.5f * scale[1] * (static_cast<float>(node[1] + o.y) - point[1]),
                dz = 0.5f * scale[2] * (static_cast<float>(node[2] + o.z) - point[2]);
    best = std::min(best, (dx * dx + dy * dy) + dz * dz);
  }
  return best;
}

/// Whether two nodes at this offset are joined by an edge of the lattice.
bool is_edge(const Reach& o) {
  const int least = std::min({o.x, o.y, o.z}), most = std::max({o.x, o.y, o.z});
  return (least >= 0 && most == 1) || (most <= 0 && least == -1);
}

/// Whether the surface passes within `limit` of a node: it crosses an edge of the node there, or
/// lies before a node there that has another label.
bool surface_near(const std::int32_t* near, const std::uint8_t* state, const float* values,
                  std::size_t node, const int (&at)[3], const std::vector<Reach>& offsets,
                  float limit) {
  const float own = std::fabs(values[node]);
  for (const Reach& o : offsets) {
    const std::size_t other = node_at(near, at[0] + o.x, at[1] + o.y, at[2] + o.z);
    if (other == kNoNode || !((state[other] ^ state[node]) & kLabel)) continue;
    const float part = is_edge(o) ? own / (own + std::fabs(values[other])) : 1.0f;
    if (o.length * part <= limit) return true;
  }
  return false;
}

/// The occupancy as a quadratic B-spline with a coefficient a voxel, minus one half, kept on the
/// side of the solid's label. Where it is linear, its zero set lies on the voxels' faces.
float solid_field(const std::int32_t* near, const std::uint8_t* state, std::size_t node, int x,
                  int y, int z) {
  constexpr float kLeast = 0.03f;
  struct Tap {
    int offset;
    float weight;
  };
  // Voxel centres are the odd nodes: beside an even one, at and two away from an odd one.
  constexpr Tap kEven[3] = {{-1, 0.5f}, {1, 0.5f}, {0, 0.0f}};
  constexpr Tap kOdd[3] = {{-2, 0.125f}, {0, 0.75f}, {2, 0.125f}};
  const bool solid = (state[node] & kSolid) != 0;
  const Tap *tx = x & 1 ? kOdd : kEven, *ty = y & 1 ? kOdd : kEven, *tz = z & 1 ? kOdd : kEven;
  float sum = 0;
  for (int k = 0; k < (z & 1 ? 3 : 2); ++k)
    for (int j = 0; j < (y & 1 ? 3 : 2); ++j)
      for (int i = 0; i < (x & 1 ? 3 : 2); ++i) {
        const std::size_t voxel =
            node_at(near, x + tx[i].offset, y + ty[j].offset, z + tz[k].offset);
        const bool object = voxel == kNoNode ? solid : (state[voxel] & kSolid) != 0;
        if (object) sum += tx[i].weight * (ty[j].weight * tz[k].weight);
      }
  return solid ? std::max(sum - 0.5f, kLeast) : std::min(sum - 0.5f, -kLeast);
}

}  // namespace

void TbbBackend::relabel_count(const BrickView& bricks, View<const std::uint8_t> active,
                               View<const std::uint8_t> state, View<const float> values,
                               View<std::uint32_t> counts) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    for (int colour = 0; colour < 8; ++colour) {
      std::uint32_t count = 0;
      if (active[brick])
        visit_colour(colour, [&](int cell) {
          const std::size_t node = kBrickCells * brick + cell;
          count += (state[node] & kFree) && wrong(state[node], values[node]);
        });
      counts[static_cast<std::size_t>(colour) * bricks.count + brick] = count;
    }
  });
}

void TbbBackend::relabel_collect(const BrickView& bricks, View<const std::uint8_t> active,
                                 View<const std::uint8_t> state, View<const float> values,
                                 View<const std::uint32_t> starts, View<std::uint32_t> nodes) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    if (!active[brick]) return;
    for (int colour = 0; colour < 8; ++colour) {
      std::uint32_t next = starts[static_cast<std::size_t>(colour) * bricks.count + brick];
      visit_colour(colour, [&](int cell) {
        const std::size_t node = kBrickCells * brick + cell;
        if ((state[node] & kFree) && wrong(state[node], values[node]))
          nodes[next++] = static_cast<std::uint32_t>(node);
      });
    }
  });
}

std::uint32_t TbbBackend::relabel_sweep(const BrickView& bricks, View<const std::uint8_t> simple,
                                        View<const float> values, float threshold,
                                        View<const std::uint32_t> nodes, View<std::uint8_t> state) {
  std::atomic<std::uint32_t> flips{0};
  for_each((nodes.size + kNodeGrain - 1) / kNodeGrain, 1, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kNodeGrain, nodes.size);
    std::uint32_t flipped = 0;
    for (std::size_t i = block * kNodeGrain; i < end; ++i) {
      const std::size_t node = nodes[i];
      if (std::fabs(values[node]) < threshold || !wrong(state[node], values[node])) continue;
      if (!simple[link_labels(bricks, state.data(), node)]) continue;
      state[node] ^= kLabel;
      ++flipped;
    }
    flips += flipped;
  });
  return flips;
}

std::uint32_t TbbBackend::lattice_mark_far(const BrickView& bricks, View<const std::uint8_t> active,
                                           const Scale& scale, float limit,
                                           View<const std::uint8_t> state, View<const float> values,
                                           View<std::uint8_t> marks) {
  float longest = 0;
  std::array<float, 8> edge_length{};
  for (int d = 1; d < 8; ++d) {
    const float dx = d & 1 ? 0.5f * scale[0] : 0, dy = d & 2 ? 0.5f * scale[1] : 0,
                dz = d & 4 ? 0.5f * scale[2] : 0;
    edge_length[d] = std::sqrt((dx * dx + dy * dy) + dz * dz);
    longest = std::max(longest, edge_length[d]);
  }
  const std::vector<Reach> search = offsets_within(scale, limit + longest, kFarReach);
  std::atomic<std::uint32_t> total{0};
  fill(marks, std::uint8_t{0});
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    if (!active[brick]) return;
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    std::uint32_t count = 0;
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const std::size_t node = kBrickCells * brick + cell;
      const int at[3] = {cell & 7, cell >> 3 & 7, cell >> 6};
      const std::uint8_t own = state[node];
      bool far = false;
      if (own & kFaceCentre) {
        far = !surface_near(near, state.data(), values.data(), node, at, search, limit);
      } else if ((own & kLabel) != (own >> 1 & 1)) {
        // A relabelled node: the crossings of its edges. Only such nodes have far ones.
        for (std::size_t i = 0; i < kLink.size() && !far; ++i) {
          const NodeOffset o = kLink[i];
          const std::size_t other = node_at(near, at[0] + o.x, at[1] + o.y, at[2] + o.z);
          if (other == kNoNode || !((state[other] ^ own) & kLabel)) continue;
          if (state[other] & kFaceCentre) continue;
          const float a = values[node], b = values[other];
          const float t = (a > 0) != (b > 0) ? a / (a - b) : 0.5f;
          const float point[3] = {static_cast<float>(at[0]) + t * static_cast<float>(o.x),
                                  static_cast<float>(at[1]) + t * static_cast<float>(o.y),
                                  static_cast<float>(at[2]) + t * static_cast<float>(o.z)};
          const float length = edge_length[i % 7 + 1];
          far = nearest_face_centre(near, state.data(), scale, search, at, point, length) >
                limit * limit;
        }
      }
      marks[node] = far;
      count += far;
    }
    total += count;
  });
  return total;
}

void TbbBackend::lattice_blend(const BrickView& bricks, View<const std::uint8_t> marks,
                               float radius, View<const std::uint8_t> state, View<float> values) {
  std::vector<std::uint8_t> marked(bricks.count);
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    const std::uint8_t* own = marks.data() + kBrickCells * brick;
    marked[brick] = std::any_of(own, own + kBrickCells, [](std::uint8_t m) { return m != 0; });
  });
  const float inverse = 1.0f / (radius * radius);
  for_each(bricks.count, 1, [&](std::size_t brick) {
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    struct Mark {
      int x, y, z;
    };
    std::vector<Mark> found;
    for (int n = 0; n < 27; ++n) {
      if (near[n] == kNoBrick || !marked[near[n]]) continue;
      const int x0 = 8 * (n % 3 - 1), y0 = 8 * (n / 3 % 3 - 1), z0 = 8 * (n / 9 - 1);
      for (int cell = 0; cell < kBrickCells; ++cell)
        if (marks[std::size_t{kBrickCells} * near[n] + cell])
          found.push_back({x0 + (cell & 7), y0 + (cell >> 3 & 7), z0 + (cell >> 6)});
    }
    if (found.empty()) return;
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const std::size_t node = kBrickCells * brick + cell;
      const int x = cell & 7, y = cell >> 3 & 7, z = cell >> 6;
      int least = 1 << 20;
      for (const Mark& m : found) {
        const int dx = m.x - x, dy = m.y - y, dz = m.z - z;
        least = std::min(least, dx * dx + dy * dy + dz * dz);
      }
      const float rest = 1.0f - static_cast<float>(least) * inverse;
      if (rest <= 0) continue;
      const float blend = rest * rest;
      values[node] =
          (1.0f - blend) * values[node] + blend * solid_field(near, state.data(), node, x, y, z);
    }
  });
}

std::uint32_t TbbBackend::lattice_clamp(const BrickView& bricks, float least,
                                        View<const std::uint8_t> state, View<float> values) {
  std::atomic<std::uint32_t> total{0};
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    std::uint32_t count = 0;
    for (std::size_t node = kBrickCells * brick; node < kBrickCells * (brick + 1); ++node) {
      if (!wrong(state[node], values[node])) continue;
      values[node] = state[node] & kLabel ? least : -least;
      count += (state[node] & kFree) != 0;
    }
    total += count;
  });
  return total;
}

}  // namespace vasamesh

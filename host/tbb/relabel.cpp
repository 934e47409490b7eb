/// Homotopic relabelling of the cell lattice and the local repair of its field.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include "types/lattice_access.h"
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

/// How a repair's field is made of the occupancy.
struct SolidField {
  bool smooth;  ///< a quadratic B-spline with a coefficient a voxel; else linear between centres
  bool keep_label;  ///< kept on the side of the solid's label
};

/// The occupancy minus one half at a node: its zero set lies on the voxels' faces where they are
/// flat.
float solid_field(const std::int32_t* near, const std::uint8_t* state, std::size_t node, int x,
                  int y, int z, const SolidField& field) {
  constexpr float kLeast = 0.03f;
  struct Tap {
    int offset;
    float weight;
  };
  // Voxel centres are the odd nodes: beside an even one; at, and two away from, an odd one.
  constexpr Tap kTaps[3][3] = {{{-1, 0.5f}, {1, 0.5f}, {0, 0.0f}},
                               {{0, 1.0f}, {0, 0.0f}, {0, 0.0f}},
                               {{-2, 0.125f}, {0, 0.75f}, {2, 0.125f}}};
  const auto taps = [&](int at) { return kTaps[at & 1 ? (field.smooth ? 2 : 1) : 0]; };
  const bool solid = (state[node] & kSolid) != 0;
  const Tap *tx = taps(x), *ty = taps(y), *tz = taps(z);
  float sum = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const float weight = tx[i].weight * (ty[j].weight * tz[k].weight);
        if (weight == 0) continue;
        const std::size_t voxel =
            node_at(near, x + tx[i].offset, y + ty[j].offset, z + tz[k].offset);
        const bool object = voxel == kNoNode ? solid : (state[voxel] & kSolid) != 0;
        if (object) sum += weight;
      }
  if (!field.keep_label) return sum - 0.5f;
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
                                        View<const std::uint32_t> nodes, View<std::uint8_t> state,
                                        View<std::uint32_t> left) {
  const std::size_t blocks = (nodes.size + kNodeGrain - 1) / kNodeGrain;
  std::vector<std::uint32_t> kept(blocks + 1, 0);  // then the blocks' starts in `left`
  std::atomic<bool> flipped{false};
  for_each(blocks, 1, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kNodeGrain, nodes.size);
    bool flips = false;
    for (std::size_t i = block * kNodeGrain; i < end; ++i) {
      const std::size_t node = nodes[i];
      if (!wrong(state[node], values[node])) continue;
      if (std::fabs(values[node]) < threshold || !simple[link_labels(bricks, state.data(), node)]) {
        ++kept[block + 1];
        continue;
      }
      state[node] ^= kLabel;
      flips = true;
    }
    if (flips) flipped = true;
  });
  if (!flipped) return static_cast<std::uint32_t>(nodes.size);
  for (std::size_t block = 0; block < blocks; ++block) kept[block + 1] += kept[block];
  for_each(blocks, 1, [&](std::size_t block) {
    const std::uint32_t* first = nodes.data() + block * kNodeGrain;
    std::copy_if(first, std::min(first + kNodeGrain, nodes.data() + nodes.size),
                 left.data() + kept[block],
                 [&](std::uint32_t node) { return wrong(state[node], values[node]); });
  });
  return kept[blocks];
}

void TbbBackend::relabel_mark(View<const std::uint32_t> nodes, std::uint8_t mark,
                              View<std::uint8_t> marks) {
  for (std::size_t i = 0; i < nodes.size; ++i) marks[nodes[i]] = mark;
}

void TbbBackend::relabel_find_marked(const BrickView& bricks, View<const std::uint8_t> marks,
                                     View<std::uint8_t> marked) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    const std::uint8_t* own = marks.data() + kBrickCells * brick;
    marked[brick] = std::any_of(own, own + kBrickCells, [](std::uint8_t m) { return m != 0; });
  });
}

void TbbBackend::lattice_blend(const BrickView& bricks, View<const std::uint8_t> marks,
                               float radius, float strength, bool smooth,
                               View<const std::uint8_t> state, View<float> values) {
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
      bool keep_label;
    };
    std::vector<Mark> found;
    for (int n = 0; n < 27; ++n) {
      if (near[n] == kNoBrick || !marked[near[n]]) continue;
      const int x0 = 8 * (n % 3 - 1), y0 = 8 * (n / 3 % 3 - 1), z0 = 8 * (n / 9 - 1);
      for (int cell = 0; cell < kBrickCells; ++cell)
        if (const std::uint8_t mark = marks[std::size_t{kBrickCells} * near[n] + cell])
          found.push_back(
              {x0 + (cell & 7), y0 + (cell >> 3 & 7), z0 + (cell >> 6), mark == kStuckMark});
    }
    if (found.empty()) return;
    for (int cell = 0; cell < kBrickCells; ++cell) {
      const std::size_t node = kBrickCells * brick + cell;
      const int x = cell & 7, y = cell >> 3 & 7, z = cell >> 6;
      int least = 1 << 20;
      bool keep_label = false;
      for (const Mark& m : found) {
        const int dx = m.x - x, dy = m.y - y, dz = m.z - z;
        least = std::min(least, dx * dx + dy * dy + dz * dz);
        keep_label |= m.keep_label && dx * dx + dy * dy + dz * dz < radius * radius;
      }
      const float rest = 1.0f - static_cast<float>(least) * inverse;
      if (rest <= 0) continue;
      const float blend = strength * (rest * rest);
      values[node] = (1.0f - blend) * values[node] +
                     blend * solid_field(near, state.data(), node, x, y, z, {smooth, keep_label});
    }
  });
}

std::uint32_t TbbBackend::lattice_clamp(const BrickView& bricks, float least,
                                        View<const std::uint8_t> state, View<float> values) {
  std::atomic<std::uint32_t> total{0};
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    std::uint32_t count = 0;
    for (std::size_t node = kBrickCells * brick; node < kBrickCells * (brick + 1); ++node) {
      const bool held = wrong(state[node], values[node]);
      if (!held && values[node] != 0) continue;
      values[node] = state[node] & kLabel ? least : -least;
      count += held && (state[node] & kFree) != 0;
    }
    total += count;
  });
  return total;
}

}  // namespace vasamesh

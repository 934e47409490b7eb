/// Homotopic relabelling of the cell lattice and the local repair of its field.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <vector>

#include "tbb/byte_rows.h"
#include "tbb/tbb_backend.h"
#include "types/lattice_access.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16;       // bricks a task takes
constexpr std::size_t kNodeGrain = 512;  // listed nodes a task takes

bool wrong(std::uint8_t state, float value) { return ((state & kLabel) != 0) != (value > 0); }

/// What the neighbours in a node's link add to its index, within a brick.
constexpr auto kLinkSteps = [] {
  std::array<std::size_t, kLink.size()> steps{};
  for (std::size_t i = 0; i < kLink.size(); ++i)
    steps[i] = static_cast<std::size_t>(brick_cell(kLink[i].x, kLink[i].y, kLink[i].z));
  return steps;
}();

/// The labels of a node's 14 neighbours; a missing one takes part as outside.
std::uint32_t link_labels(const BrickView& bricks, const std::uint8_t* state, std::size_t node) {
  const std::size_t brick = node / kBrickCells;
  const int cell = static_cast<int>(node % kBrickCells);
  const int x = cell & 7, y = cell >> 3 & 7, z = cell >> 6;
  const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
  std::uint32_t labels = 0;
  if (x > 0 && x < 7 && y > 0 && y < 7 && z > 0 && z < 7) {
    for (std::size_t i = 0; i < kLink.size(); ++i)
      labels |= (state[node + kLinkSteps[i]] & std::uint32_t{kLabel}) << i;
    return labels;
  }
  for (std::size_t i = 0; i < kLink.size(); ++i) {
    const std::size_t other = node_at(near, x + kLink[i].x, y + kLink[i].y, z + kLink[i].z);
    if (other != kNoNode) labels |= (state[other] & std::uint32_t{kLabel}) << i;
  }
  return labels;
}

/// The nodes of a row that may change and have a label that is not their value's sign.
std::uint32_t wanted_row(const std::uint8_t* state, const float* values, int row) {
  const std::uint64_t bytes = load_bytes(state, row);
  const std::uint32_t may_change = byte_bits(bytes, kFree);
  if (may_change == 0) return 0;
  std::uint32_t inside = 0;
  for (int x = 0; x < 8; ++x) inside |= std::uint32_t{values[8 * row + x] > 0} << x;
  return (byte_bits(bytes, kLabel) ^ inside) & may_change;
}

/// Where a surface is narrow: arguments of lattice_mark_narrow.
struct NarrowTest {
  const BrickView& bricks;
  const std::uint8_t* simple;
  const std::uint8_t* state;
  const float* values;
  LeastWidths least;

  /// \param x, y, z  of a voxel centre in the brick: all odd.
  bool holds(std::size_t brick, int x, int y, int z) const {
    const std::size_t node = kBrickCells * brick + static_cast<std::size_t>(brick_cell(x, y, z));
    const std::uint8_t own = state[node];
    const bool inside = (own & kLabel) != 0;
    if (inside != ((own & kSolid) != 0)) return false;
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    int closed = 0;
    bool is_narrow = false, is_thin_sheet = false;
    for (const NodeOffset& along : {kLink[0], kLink[1], kLink[3]}) {
      const std::size_t below = node_at(near, x - along.x, y - along.y, z - along.z);
      if (((state[below] ^ own) & kLabel) == 0) continue;
      const std::size_t above = node_at(near, x + along.x, y + along.y, z + along.z);
      if (above == kNoNode || ((state[above] ^ own) & kLabel) == 0) continue;
      ++closed;
      const float across = width(node, below, above);
      is_narrow |= across < least.across;
      is_thin_sheet |= across < least.sheet;
    }
    return ((closed >= 2 && is_narrow) || (inside && is_thin_sheet)) &&
           !simple[link_labels(bricks, state, node)];
  }

  float width(std::size_t node, std::size_t below, std::size_t above) const {
    const float own = std::fabs(values[node]);
    return 0.5f * (own / (own + std::fabs(values[below])) + own / (own + std::fabs(values[above])));
  }
};

/// The first colour of the nodes of a row; those of odd x have the next.
std::size_t row_colour(int row) {
  return static_cast<std::size_t>(2 * (row & 1) + 4 * (row >> 3 & 1));
}

constexpr std::uint32_t kEvenNodes = 0x55;

/// The marks within a radius of a brick's nodes.
class MarksNear {
 public:
  MarksNear(const std::int32_t* near, const std::vector<std::uint8_t>& marked,
            const std::uint8_t* marks, float radius)
      : inside_(static_cast<int>(std::ceil(radius * radius))),
        reach_(static_cast<int>(std::ceil(radius)) - 1) {
    for (int n = 0; n < 27; ++n) {
      if (near[n] == kNoBrick || !marked[static_cast<std::size_t>(near[n])]) continue;
      const std::uint8_t* brick = marks + std::size_t{kBrickCells} * near[n];
      for (int row = 0; row < kBrickRows; ++row) {
        if (load_bytes(brick, row) == 0) continue;
        for (int x = 0; x < 8; ++x)
          if (const std::uint8_t mark = brick[8 * row + x])
            add({8 * (n % 3 - 1) + x, 8 * (n / 3 % 3 - 1) + (row & 7),
                 8 * (n / 9 - 1) + (row >> 3)},
                mark == kStuckMark);
      }
    }
  }

  bool any() const { return any_; }
  /// Of a node's distance to the nearest mark; the radius' own or more where none is within it.
  int square(int cell) const { return any_ ? square_[cell] : inside_; }
  /// Whether a kStuckMark is within the radius of a node.
  bool keeps_label(int cell) const { return keeps_label_[cell]; }

 private:
  void add(const std::array<int, 3>& mark, bool stuck) {
    std::array<int, 3> low, high;
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(mark[a] - reach_, 0);
      high[a] = std::min(mark[a] + reach_, 7);
      if (low[a] > high[a]) return;
    }
    if (!any_) {
      std::fill_n(square_, kBrickCells, inside_);
      std::fill_n(keeps_label_, kBrickCells, false);
    }
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x) {
          const int dx = mark[0] - x, dy = mark[1] - y, dz = mark[2] - z;
          const int square = dx * dx + dy * dy + dz * dz;
          if (square >= inside_) continue;
          any_ = true;
          const int cell = brick_cell(x, y, z);
          square_[cell] = std::min(square_[cell], square);
          keeps_label_[cell] |= stuck;
        }
  }

  int inside_;  // squares below it are within the radius
  int reach_;   // nodes along each axis
  bool any_ = false;
  int square_[kBrickCells];
  bool keeps_label_[kBrickCells];
};

/// How a repair's field is made of the occupancy.
struct SolidField {
  bool smooth;  ///< a quadratic B-spline with a coefficient a voxel; else linear between centres
  bool keep_label;  ///< kept on the side of the solid's label
};

/// The occupancy minus one half at a node: its zero set lies on the voxels' faces where they are
/// flat.
float occupancy(const std::int32_t* near, const std::uint8_t* state, std::size_t node, int x, int y,
                int z, bool smooth) {
  struct Tap {
    int offset;
    float weight;
  };
  // Voxel centres are the odd nodes: beside an even one; at, and two away from, an odd one.
  constexpr Tap kTaps[3][3] = {{{-1, 0.5f}, {1, 0.5f}, {0, 0.0f}},
                               {{0, 1.0f}, {0, 0.0f}, {0, 0.0f}},
                               {{-2, 0.125f}, {0, 0.75f}, {2, 0.125f}}};
  const auto taps = [&](int at) { return kTaps[at & 1 ? (smooth ? 2 : 1) : 0]; };
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
  return sum - 0.5f;
}

/// The occupancy, smooth or not; where the label is kept, the sharp one for solid nodes that the
/// smooth one would lose.
float solid_field(const std::int32_t* near, const std::uint8_t* state, std::size_t node, int x,
                  int y, int z, const SolidField& field) {
  const float value = occupancy(near, state, node, x, y, z, field.smooth);
  if (!field.keep_label) return value;
  if (!(state[node] & kSolid)) return std::min(value, -kLeastOccupancy);
  if (value >= kLeastOccupancy || !field.smooth) return std::max(value, kLeastOccupancy);
  return std::max(occupancy(near, state, node, x, y, z, false), kLeastOccupancy);
}

}  // namespace

void TbbBackend::relabel_count(const BrickView& bricks, View<const std::uint8_t> active,
                               View<const std::uint8_t> state, View<const float> values,
                               View<std::uint32_t> counts) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    std::array<std::uint32_t, 8> count{};
    for (int row = 0; active[brick] && row < kBrickRows; ++row) {
      const std::uint32_t wanted =
          wanted_row(state.data() + kBrickCells * brick, values.data() + kBrickCells * brick, row);
      count[row_colour(row)] += static_cast<std::uint32_t>(std::popcount(wanted & kEvenNodes));
      count[row_colour(row) + 1] += static_cast<std::uint32_t>(std::popcount(wanted & ~kEvenNodes));
    }
    for (std::size_t colour = 0; colour < 8; ++colour)
      counts[colour * bricks.count + brick] = count[colour];
  });
}

void TbbBackend::relabel_collect(const BrickView& bricks, View<const std::uint8_t> active,
                                 View<const std::uint8_t> state, View<const float> values,
                                 View<const std::uint32_t> starts, View<std::uint32_t> nodes) {
  for_each(bricks.count, kGrain, [=](std::size_t brick) {
    if (!active[brick]) return;
    std::array<std::uint32_t, 8> next;
    for (std::size_t colour = 0; colour < 8; ++colour)
      next[colour] = starts[colour * bricks.count + brick];
    for (int row = 0; row < kBrickRows; ++row)
      for_each_bit(
          wanted_row(state.data() + kBrickCells * brick, values.data() + kBrickCells * brick, row),
          [&](int x) {
            nodes[next[row_colour(row) + (x & 1)]++] =
                static_cast<std::uint32_t>(kBrickCells * brick) +
                static_cast<std::uint32_t>(8 * row + x);
          });
  });
}

std::uint32_t TbbBackend::relabel_sweep(const BrickView& bricks, View<const std::uint8_t> simple,
                                        View<const float> values, float threshold,
                                        View<const std::uint32_t> nodes, View<std::uint8_t> state,
                                        View<std::uint32_t> left) {
  const std::size_t blocks = (nodes.size + kNodeGrain - 1) / kNodeGrain;
  std::vector<std::size_t> kept(blocks);  // of each block, from its own place in `left` on
  for_each(blocks, 1, [&](std::size_t block) {
    const std::size_t first = block * kNodeGrain;
    std::uint32_t* next = left.data() + first;
    for (std::size_t i = first; i < std::min(first + kNodeGrain, nodes.size); ++i) {
      const std::uint32_t node = nodes[i];
      if (std::fabs(values[node]) < threshold || !simple[link_labels(bricks, state.data(), node)])
        *next++ = node;
      else
        state[node] ^= kLabel;
    }
    kept[block] = static_cast<std::size_t>(next - (left.data() + first));
  });
  std::uint32_t* end = left.data();
  for (std::size_t block = 0; block < blocks; ++block)
    end = std::copy_n(left.data() + block * kNodeGrain, kept[block], end);
  return static_cast<std::uint32_t>(end - left.data());
}

void TbbBackend::relabel_mark(View<const std::uint32_t> nodes, std::uint8_t mark,
                              View<std::uint8_t> marks) {
  for_each(nodes.size, kNodeGrain, [&](std::size_t i) { marks[nodes[i]] = mark; });
}

std::uint32_t TbbBackend::lattice_mark_narrow(const BrickView& bricks,
                                              View<const std::uint8_t> active,
                                              View<const std::uint8_t> simple,
                                              const LeastWidths& least,
                                              View<const std::uint8_t> state,
                                              View<const float> values, View<std::uint8_t> marks) {
  const NarrowTest test{bricks, simple.data(), state.data(), values.data(), least};
  std::atomic<std::uint32_t> total{0};
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    std::uint32_t count = 0;
    for (int z = 1; z < 8; z += 2)
      for (int y = 1; y < 8; y += 2)
        for (int x = 1; x < 8; x += 2) {
          const int octant = (x >> 2) + 2 * (y >> 2) + 4 * (z >> 2);
          if (!(active[brick] >> octant & 1) || !test.holds(brick, x, y, z)) continue;
          marks[kBrickCells * brick + static_cast<std::size_t>(brick_cell(x, y, z))] = kStuckMark;
          ++count;
        }
    total += count;
  });
  return total;
}

void TbbBackend::lattice_blend(const BrickView& bricks, View<const std::uint8_t> marks,
                               float radius, float strength, bool smooth,
                               View<const std::uint8_t> state, View<float> values,
                               View<std::uint8_t> changed) {
  std::vector<std::uint8_t> marked(bricks.count);
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    const std::uint8_t* own = marks.data() + kBrickCells * brick;
    std::uint64_t any = 0;
    for (int row = 0; row < kBrickRows; ++row) any |= load_bytes(own, row);
    marked[brick] = any != 0;
  });
  const float inverse = 1.0f / (radius * radius);
  for_each(bricks.count, kGrain, [&](std::size_t brick) {
    const std::int32_t* near = bricks.neighbours.data() + 27 * brick;
    const MarksNear found(near, marked, marks.data(), radius);
    std::uint32_t octants = 0;
    for (int cell = 0; found.any() && cell < kBrickCells; ++cell) {
      const float rest = 1.0f - static_cast<float>(found.square(cell)) * inverse;
      if (rest <= 0) continue;
      octants |= 1u << ((cell >> 2 & 1) + 2 * (cell >> 5 & 1) + 4 * (cell >> 8));
      const std::size_t node = kBrickCells * brick + static_cast<std::size_t>(cell);
      const float blend = strength * (rest * rest);
      values[node] = (1.0f - blend) * values[node] +
                     blend * solid_field(near, state.data(), node, cell & 7, cell >> 3 & 7,
                                         cell >> 6, {smooth, found.keeps_label(cell)});
    }
    changed[brick] = static_cast<std::uint8_t>(octants);
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

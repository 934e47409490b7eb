#include "stages/close_handles.h"

#include <unordered_set>

#include "stages/link.h"

namespace vasamesh {

namespace {

/// Outside nodes searched for a way from one side of a tunnel to the other.
constexpr std::size_t kSearchLimit = 200'000;

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Nodes of a lattice in the host's memory.
class Nodes {
 public:
  Nodes(Backend& backend, Lattice& lattice)
      : state_(backend.on_host(lattice.state.view())),
        values_(backend.on_host(View<const float>(lattice.values.view()))),
        coords_(backend.on_host(View<const BrickCoord>(lattice.bricks.coords.view()))),
        neighbours_(backend.on_host(View<const std::int32_t>(lattice.bricks.neighbours.view()))) {}

  bool inside(std::uint32_t node) const { return (state_[node] & kLabel) != 0; }
  void set_inside(std::uint32_t node) { state_[node] |= kLabel; }
  bool wants_inside(std::uint32_t node) const { return !inside(node) && values_[node] > 0; }

  std::array<int, 3> place(std::uint32_t node) const {
    const BrickCoord c = coords_[node / kBrickCells];
    const int cell = static_cast<int>(node % kBrickCells);
    return {8 * c.x + (cell & 7), 8 * c.y + (cell >> 3 & 7), 8 * c.z + (cell >> 6)};
  }

  /// The neighbour in the link, or kNone past the lattice's bricks.
  std::uint32_t neighbour(std::uint32_t node, const NodeOffset& offset) const {
    const int cell = static_cast<int>(node % kBrickCells);
    const int x = (cell & 7) + offset.x, y = (cell >> 3 & 7) + offset.y, z = (cell >> 6) + offset.z;
    const int slot = brick_neighbour(x >> 3, y >> 3, z >> 3);
    const std::int32_t brick =
        neighbours_[27 * std::size_t{node / kBrickCells} + static_cast<std::size_t>(slot)];
    if (brick == kNoBrick) return kNone;
    return static_cast<std::uint32_t>(brick) * kBrickCells +
           static_cast<std::uint32_t>(brick_cell(x & 7, y & 7, z & 7));
  }

  /// Labels of the link; nodes past the lattice count as outside, as they do in the sweeps.
  std::uint32_t link_labels(std::uint32_t node) const {
    std::uint32_t labels = 0;
    for (std::size_t i = 0; i < kLink.size(); ++i) {
      const std::uint32_t other = neighbour(node, kLink[i]);
      if (other != kNone && inside(other)) labels |= 1u << i;
    }
    return labels;
  }

 private:
  std::span<std::uint8_t> state_;
  std::span<const float> values_;
  std::span<const BrickCoord> coords_;
  std::span<const std::int32_t> neighbours_;
};

/// Whether a way through outside nodes, not over `node`, leads from one part of its link to the
/// rest of the link's outside.
bool joined_elsewhere(const Nodes& nodes, std::uint32_t node, std::uint32_t part,
                      std::uint32_t rest) {
  std::unordered_set<std::uint32_t> seen = {node}, goals;
  std::vector<std::uint32_t> queue;
  for (std::size_t i = 0; i < kLink.size(); ++i) {
    const std::uint32_t other = nodes.neighbour(node, kLink[i]);
    if (other == kNone) continue;
    if (part >> i & 1 && seen.insert(other).second) queue.push_back(other);
    if (rest >> i & 1) goals.insert(other);
  }
  for (std::size_t next = 0; next < queue.size() && queue.size() < kSearchLimit; ++next)
    for (const NodeOffset& offset : kLink) {
      const std::uint32_t other = nodes.neighbour(queue[next], offset);
      if (other == kNone || nodes.inside(other) || !seen.insert(other).second) continue;
      if (goals.contains(other)) return true;
      queue.push_back(other);
    }
  return false;
}

/// The piece whose voxels are nearest to a node of the cell lattice; kNone past two voxels.
std::int32_t piece_near(const PieceLookup& lookup, const std::array<int, 3>& node) {
  for (int reach = 0; reach <= 2; ++reach)
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const std::int32_t piece =
              lookup.at((node[0] >> 1) + x, (node[1] >> 1) + y, (node[2] >> 1) + z);
          if (piece != PieceLookup::kNone) return piece;
        }
  return PieceLookup::kNone;
}

}  // namespace

std::size_t close_handles(Backend& backend, Lattice& lattice,
                          const std::array<std::vector<std::uint32_t>, 8>& stuck,
                          std::vector<Closing>& closings) {
  constexpr std::uint32_t kAll = kLinkCount - 1;
  Nodes nodes(backend, lattice);
  const std::size_t before = closings.size();
  for (const auto& list : stuck)
    for (const std::uint32_t node : list) {
      if (!nodes.wants_inside(node)) continue;
      const std::uint32_t labels = nodes.link_labels(node);
      const std::uint32_t outside = ~labels & kAll;
      const bool cavity = outside == 0;
      if (!cavity) {
        const std::uint32_t part = link_component(outside);
        if (link_components(labels) != 1 || link_components(outside) != 2 ||
            !joined_elsewhere(nodes, node, part, outside & ~part))
          continue;
      }
      nodes.set_inside(node);
      closings.push_back({!cavity, nodes.place(node)});
    }
  return closings.size() - before;
}

void take_off(const std::vector<Closing>& closings, Solid& solid, RelabelReport& report) {
  for (const Closing& closing : closings) {
    const std::int32_t piece = piece_near(solid.lookup, closing.node);
    if (piece == PieceLookup::kNone) continue;
    Piece& own = solid.findings.pieces[static_cast<std::size_t>(piece)];
    --(closing.tunnel ? own.handles : own.cavities);
    --(closing.tunnel ? solid.topology.handles : solid.topology.cavities);
    ++(closing.tunnel ? report.handles_closed : report.cavities_closed);
  }
}

}  // namespace vasamesh

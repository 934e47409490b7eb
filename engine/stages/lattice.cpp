#include "stages/lattice.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stages/bricks.h"

namespace vasamesh {

namespace {

/// The thresholds of |value| that nodes must pass to flip, in turn: largest first.
constexpr std::array<float, 7> kThresholds = {0.4f, 0.25f, 0.15f, 0.08f, 0.04f, 0.02f, 0.0f};

/// Radius of the repair round a mark, in nodes, pass by pass.
constexpr std::array<float, 7> kRepairRadius = {3, 3, 4, 4, 5, 6, 8};

/// What a node gets whose value's sign is not its label at the end.
constexpr float kLeastValue = 0.02f;

/// Part of the distance limit that the labels may use; the rest is for the surface between.
constexpr float kDistanceShare = 0.8f;

/// Whether two neighbours in a node's link are joined.
bool joined(const NodeOffset& a, const NodeOffset& b) {
  const int x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
  const int least = std::min({x, y, z}), most = std::max({x, y, z});
  return (least >= 0 && most == 1) || (most <= 0 && least == -1);
}

/// Connected parts among the link's nodes in `members`.
int component_count(std::uint32_t members, const std::array<std::uint32_t, 14>& joins) {
  int count = 0;
  while (members) {
    ++count;
    std::uint32_t reached = members & (~members + 1), before = 0;
    while (reached != before) {
      before = reached;
      for (std::size_t i = 0; i < joins.size(); ++i)
        if (before >> i & 1) reached |= joins[i] & members;
    }
    members &= ~reached;
  }
  return count;
}

/// Nodes along each axis round a face centre that may change their label.
std::array<int, 3> free_radius(const Scale& scale) {
  const float limit = kDistanceShare * distance_limit(scale);
  std::array<int, 3> radius;
  for (std::size_t i = 0; i < 3; ++i)
    radius[i] = std::clamp(static_cast<int>(limit / (0.5f * scale[i])), 1, 3);
  return radius;
}

/// Bricks of 4 x 4 x 4 voxels that could hold free nodes or neighbours of them: those within two
/// voxels of an octant that holds outer boundary voxels.
std::vector<BrickCoord> candidate_bricks(Backend& backend, const PointCloud& points) {
  std::vector<BrickCoord> coords(points.bricks.count);
  std::vector<std::uint8_t> octants(points.bricks.count);
  backend.download<BrickCoord>(points.bricks.coords.view(), coords);
  backend.download<std::uint8_t>(points.octants.view(), octants);
  std::vector<BrickCoord> fine;
  for (std::size_t i = 0; i < coords.size(); ++i)
    for (int octant = 0; octant < 8; ++octant)
      if (octants[i] >> octant & 1)
        fine.push_back({2 * coords[i].x + (octant & 1), 2 * coords[i].y + (octant >> 1 & 1),
                        2 * coords[i].z + (octant >> 2)});
  const std::vector<std::uint8_t> all(fine.size(), 0xff);
  return dilate_by_octants(fine, all);
}

std::vector<BrickCoord> used_bricks(Backend& backend, const BitView& object,
                                    const std::vector<BrickCoord>& candidates,
                                    const std::array<int, 3>& radius) {
  Buffer<BrickCoord> coords(backend, candidates.size());
  backend.upload<BrickCoord>(coords.view(), candidates);
  Buffer<std::uint8_t> used(backend, candidates.size());
  backend.lattice_mark(object, {candidates.size(), coords.view(), {}}, radius, used.view());
  std::vector<std::uint8_t> flags(candidates.size());
  backend.download<std::uint8_t>(used.view(), flags);
  std::vector<BrickCoord> kept;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (flags[i]) kept.push_back(candidates[i]);
  return kept;
}

/// The nodes to flip, by colour.
struct Pending {
  std::array<std::vector<std::uint32_t>, 8> nodes;

  std::size_t count() const {
    std::size_t sum = 0;
    for (const auto& list : nodes) sum += list.size();
    return sum;
  }
};

/// One relabelling of a lattice: lists, sweeps, what is left.
class Relabelling {
 public:
  Relabelling(Backend& backend, Lattice& lattice) : backend_(backend), lattice_(lattice) {
    const auto table = make_simple_table();
    simple_ = Buffer<std::uint8_t>(backend, table.size());
    backend.upload<std::uint8_t>(simple_.view(), table);
  }

  /// Flips all that can be flipped. \return how many.
  std::int64_t run() {
    collect();
    std::int64_t flips = 0;
    for (const float threshold : kThresholds)
      for (std::int64_t round = -1; round != 0;) {
        round = 0;
        for (std::size_t colour = 0; colour < 8; ++colour) round += sweep(colour, threshold);
        flips += round;
      }
    return flips;
  }

  /// Nodes left that could not be flipped.
  const Pending& stuck() const { return pending_; }

 private:
  void collect() {
    const BrickView bricks = lattice_.bricks.view();
    counts_.resize(backend_, 8 * bricks.count + 1);
    const auto counts = counts_.view();
    backend_.relabel_count(bricks, lattice_.state.view(), lattice_.values.view(),
                           counts.subview(0, 8 * bricks.count));
    const std::uint32_t total =
        backend_.exclusive_scan(counts.subview(0, 8 * bricks.count), counts);
    Buffer<std::uint32_t> nodes(backend_, total);
    backend_.relabel_collect(bricks, lattice_.state.view(), lattice_.values.view(), counts,
                             nodes.view());
    std::vector<std::uint32_t> starts(counts.size);
    backend_.download<std::uint32_t>(counts, starts);
    for (std::size_t colour = 0; colour < 8; ++colour) {
      const std::uint32_t first = starts[colour * bricks.count];
      pending_.nodes[colour].resize(starts[(colour + 1) * bricks.count] - first);
      backend_.download<std::uint32_t>(nodes.view().subview(first, pending_.nodes[colour].size()),
                                       pending_.nodes[colour]);
    }
  }

  std::uint32_t sweep(std::size_t colour, float threshold) {
    std::vector<std::uint32_t>& nodes = pending_.nodes[colour];
    if (nodes.empty()) return 0;
    list_.resize(backend_, nodes.size());
    backend_.upload<std::uint32_t>(list_.view(), nodes);
    const std::uint32_t flips =
        backend_.relabel_sweep(lattice_.bricks.view(), simple_.view(), lattice_.values.view(),
                               threshold, list_.view(), lattice_.state.view());
    if (flips == 0) return 0;
    // The labels and values are in host memory: the lattice stage runs on the host's backend.
    const auto state = lattice_.state.view();
    const auto values = lattice_.values.view();
    std::erase_if(nodes, [&](std::uint32_t node) {
      return ((state[node] & kLabel) != 0) == (values[node] > 0);
    });
    return flips;
  }

  Backend& backend_;
  Lattice& lattice_;
  Buffer<std::uint8_t> simple_;
  Buffer<std::uint32_t> counts_, list_;
  Pending pending_;
};

}  // namespace

std::array<std::uint8_t, kLinkCount> make_simple_table() {
  std::array<std::uint32_t, 14> joins{};
  for (std::size_t i = 0; i < kLink.size(); ++i)
    for (std::size_t j = 0; j < kLink.size(); ++j)
      if (i != j && joined(kLink[i], kLink[j])) joins[i] |= 1u << j;
  std::array<std::uint8_t, kLinkCount> simple{};
  for (std::uint32_t labels = 0; labels < kLinkCount; ++labels)
    simple[labels] = component_count(labels, joins) == 1 &&
                     component_count(~labels & (kLinkCount - 1), joins) == 1;
  return simple;
}

float distance_limit(const Scale& scale) {
  const auto [least, most] = std::minmax_element(scale.begin(), scale.end());
  return std::max(*least, 0.55f * *most);
}

Lattice build_lattice(Backend& backend, const BitVolume& object, const PointCloud& points,
                      const Scale& scale, const Octree& octree, const Parameters& parameters) {
  const std::array<int, 3> radius = free_radius(scale);
  const std::vector<BrickCoord> coords =
      used_bricks(backend, object.view(), candidate_bricks(backend, points), radius);
  Lattice lattice;
  lattice.bricks = make_bricks(backend, coords);
  const std::size_t nodes = coords.size() * kBrickCells;
  lattice.state = Buffer<std::uint8_t>(backend, nodes);
  lattice.values = Buffer<float>(backend, nodes);
  backend.lattice_label(object.view(), static_cast<int>(parameters.connectivity),
                        lattice.bricks.view(), radius, lattice.state.view());

  std::vector<BrickCoord> parents = coords;
  for (BrickCoord& c : parents) c = {c.x >> 1, c.y >> 1, c.z >> 1};
  const OctreeLevel& regular = octree.at_exponent(0);
  const auto in_regular = neighbours_in(backend, parents, regular.coords);
  const std::span<const BrickCoord> refined_coords =
      octree.has_refined() ? std::span<const BrickCoord>(octree.at_exponent(-1).coords)
                           : std::span<const BrickCoord>();
  const auto in_refined = neighbours_in(backend, coords, refined_coords);
  const View<const float> refined =
      octree.has_refined() ? octree.at_exponent(-1).solution.view() : View<const float>();
  backend.lattice_sample(lattice.bricks.view(), in_regular.view(), regular.solution.view(),
                         in_refined.view(), refined, lattice.values.view());
  return lattice;
}

RelabelReport relabel(Scheduler& scheduler, const Scale& scale, Lattice& lattice) {
  Backend& backend = scheduler.backend_for(Stage::lattice);
  const BrickView bricks = lattice.bricks.view();
  const float limit = kDistanceShare * distance_limit(scale);
  RelabelReport report;
  report.lattice_nodes = static_cast<std::int64_t>(bricks.count * kBrickCells);
  Relabelling relabelling(backend, lattice);
  Buffer<std::uint8_t> marks(backend, bricks.count * kBrickCells);
  for (std::size_t pass = 0;; ++pass) {
    report.flips += relabelling.run();
    const Pending& stuck = relabelling.stuck();
    if (pass == 0) report.stuck_first = static_cast<std::int64_t>(stuck.count());
    const std::uint32_t far = backend.lattice_mark_far(bricks, scale, limit, lattice.state.view(),
                                                       lattice.values.view(), marks.view());
    if ((far == 0 && stuck.count() == 0) || pass == kRepairRadius.size()) break;
    for (const auto& nodes : stuck.nodes)
      for (const std::uint32_t node : nodes) marks.view()[node] = 1;
    backend.lattice_blend(bricks, marks.view(), kRepairRadius[pass], lattice.state.view(),
                          lattice.values.view());
    ++report.repair_passes;
    scheduler.progress(
        "topology", static_cast<double>(pass + 1) / static_cast<double>(kRepairRadius.size() + 1));
  }
  report.clamped =
      backend.lattice_clamp(bricks, kLeastValue, lattice.state.view(), lattice.values.view());
  return report;
}

}  // namespace vasamesh

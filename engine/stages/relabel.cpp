#include "stages/relabel.h"

#include <algorithm>

#include "stages/close_handles.h"
#include "stages/lattice.h"
#include "stages/link.h"

namespace vasamesh {

namespace {

/// The thresholds of |value| that nodes must pass to flip, in turn: largest first.
constexpr std::array<float, 7> kThresholds = {0.4f, 0.25f, 0.15f, 0.08f, 0.04f, 0.02f, 0.0f};

/// The repair round a mark, pass by pass: gently at first, so that the natural steps of anisotropic
/// voxels do not spread over the surface.
struct Repair {
  float radius;  ///< nodes
  float strength;
  bool smooth;  ///< towards the smoothed occupancy; sharp where that loses thin parts
};
constexpr std::array<Repair, 8> kRepairs = {{{2, 0.5f, true},
                                             {2, 0.5f, true},
                                             {2, 1, true},
                                             {2, 1, false},
                                             {2, 1, false},
                                             {3, 1, false},
                                             {3, 1, false},
                                             {4, 1, false}}};

/// What a node gets whose value's sign is not its label at the end.
constexpr float kLeastValue = 0.02f;

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
  Relabelling(Backend& backend, Lattice& lattice)
      : backend_(backend), lattice_(lattice), active_(lattice.bricks.count, 1) {
    const auto table = make_simple_table();
    simple_ = Buffer<std::uint8_t>(backend, table.size());
    backend.upload<std::uint8_t>(simple_.view(), table);
  }

  /// Flips all that can be flipped in the active bricks. \return how many.
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

  /// Marks stuck nodes and those that left the solid too far. \return how many are too far.
  std::uint32_t mark(const Scale& scale, View<std::uint8_t> marks) {
    const float limit = kDistanceShare * distance_limit(scale);
    const std::uint32_t far =
        backend_.lattice_mark_far(lattice_.bricks.view(), upload_active(), scale, limit,
                                  lattice_.state.view(), lattice_.values.view(), marks);
    for (const auto& nodes : pending_.nodes)
      for (const std::uint32_t node : nodes) marks[node] = kStuckMark;
    return far;
  }

  /// Leads the field back to the solid round the marks; the bricks that this can change are the
  /// active ones from then on.
  void repair(View<const std::uint8_t> marks, const Repair& repair) {
    backend_.lattice_blend(lattice_.bricks.view(), marks, repair.radius, repair.strength,
                           repair.smooth, lattice_.state.view(), lattice_.values.view());
    std::fill(active_.begin(), active_.end(), std::uint8_t{0});
    for (std::size_t b = 0; b < active_.size(); ++b) {
      const std::uint8_t* own = marks.data() + kBrickCells * b;
      active_[b] = std::any_of(own, own + kBrickCells, [](std::uint8_t m) { return m != 0; });
    }
    grow_active();  // the blend's reach
    grow_active();  // what its flips can bring near or far
  }

 private:
  void collect() {
    const BrickView bricks = lattice_.bricks.view();
    counts_.resize(backend_, 8 * bricks.count + 1);
    const auto counts = counts_.view();
    const View<const std::uint8_t> active = upload_active();
    backend_.relabel_count(bricks, active, lattice_.state.view(), lattice_.values.view(),
                           counts.subview(0, 8 * bricks.count));
    const std::uint32_t total =
        backend_.exclusive_scan(counts.subview(0, 8 * bricks.count), counts);
    Buffer<std::uint32_t> nodes(backend_, total);
    backend_.relabel_collect(bricks, active, lattice_.state.view(), lattice_.values.view(), counts,
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

  View<const std::uint8_t> upload_active() {
    active_view_.resize(backend_, active_.size());
    backend_.upload<std::uint8_t>(active_view_.view(), active_);
    return active_view_.view();
  }

  void grow_active() {
    const std::vector<std::uint8_t> before = active_;
    const auto neighbours = lattice_.bricks.neighbours.view();
    for (std::size_t b = 0; b < before.size(); ++b)
      for (std::size_t n = 0; n < 27 && !active_[b]; ++n) {
        const std::int32_t other = neighbours[27 * b + n];
        if (other != kNoBrick && before[static_cast<std::size_t>(other)]) active_[b] = 1;
      }
  }

  Backend& backend_;
  Lattice& lattice_;
  std::vector<std::uint8_t> active_;  ///< bricks whose values have changed, and those round them
  Buffer<std::uint8_t> active_view_;
  Buffer<std::uint8_t> simple_;
  Buffer<std::uint32_t> counts_, list_;
  Pending pending_;
};

/// Forgets the boundary faces that a closing has buried: none is to be near the surface again.
void forget_buried_faces(Lattice& lattice) {
  constexpr float kBuried = 0.2f;
  const auto state = lattice.state.view();
  const auto values = lattice.values.view();
  for (std::size_t node = 0; node < state.size; ++node)
    if ((state[node] & kLabel) && values[node] > kBuried)
      state[node] = static_cast<std::uint8_t>(state[node] & ~kFaceCentre);
}

}  // namespace

RelabelReport relabel(Scheduler& scheduler, const Scale& scale, Lattice& lattice,
                      std::vector<Closing>* closings) {
  Backend& backend = scheduler.backend_for(Stage::lattice);
  RelabelReport report;
  report.lattice_nodes = static_cast<std::int64_t>(lattice.values.size());
  Relabelling relabelling(backend, lattice);
  Buffer<std::uint8_t> marks(backend, lattice.values.size());
  report.flips = relabelling.run();
  while (closings && close_handles(lattice, relabelling.stuck().nodes, *closings))
    report.flips += relabelling.run();
  if (closings && !closings->empty()) forget_buried_faces(lattice);
  report.stuck_first = static_cast<std::int64_t>(relabelling.stuck().count());
  for (const Repair& repair : kRepairs) {
    const std::uint32_t far = relabelling.mark(scale, marks.view());
    if (far == 0 && relabelling.stuck().count() == 0) break;
    relabelling.repair(marks.view(), repair);
    report.flips += relabelling.run();
    ++report.repair_passes;
    scheduler.progress("topology", static_cast<double>(report.repair_passes) /
                                       static_cast<double>(kRepairs.size() + 1));
  }
  report.clamped = backend.lattice_clamp(lattice.bricks.view(), kLeastValue, lattice.state.view(),
                                         lattice.values.view());
  return report;
}

}  // namespace vasamesh

#include "stages/relabel.h"

#include <algorithm>
#include <span>

#include "backend/in_steps.h"
#include "stages/close_handles.h"
#include "stages/far_offsets.h"
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

/// A line of voxels that has 1 along the axes across it has the area of marching cubes, half a
/// voxel's. Sheets, of which thick slices are full, are left thinner: led back, they are too rough
/// for the front.
constexpr LeastWidths kLeastWidths = {.across = 0.8f, .sheet = 0.6f};

/// What a node gets whose value's sign is not its label at the end.
constexpr float kLeastValue = 0.02f;

/// The nodes of one colour that are to flip: a part of one of two buffers, in turn.
struct Pending {
  std::size_t first = 0, count = 0;
  std::size_t buffer = 0;
};

constexpr std::uint8_t kAllOctants = 0xff;

/// One relabelling of a lattice: lists, sweeps, what is left.
class Relabelling {
 public:
  Relabelling(Backend& backend, Lattice& lattice)
      : backend_(backend), lattice_(lattice), active_(lattice.bricks.count, kAllOctants) {
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
        for (Pending& pending : pending_)
          round += static_cast<std::int64_t>(sweep(pending, threshold));
        flips += round;
      }
    return flips;
  }

  /// How many nodes are left that could not be flipped.
  std::size_t stuck_count() const {
    std::size_t sum = 0;
    for (const Pending& pending : pending_) sum += pending.count;
    return sum;
  }

  /// Those nodes, by colour.
  std::array<std::vector<std::uint32_t>, 8> stuck() {
    std::array<std::vector<std::uint32_t>, 8> nodes;
    for (std::size_t colour = 0; colour < 8; ++colour) {
      nodes[colour].resize(pending_[colour].count);
      backend_.download<std::uint32_t>(listed(pending_[colour]), nodes[colour]);
    }
    return nodes;
  }

  /// Marks stuck nodes, those that left the solid too far and narrow places. \return how many there
  /// are of the latter two.
  std::uint32_t mark(const Scale& scale, View<std::uint8_t> marks) {
    const float limit = kDistanceShare * lattice_.limit;
    upload(active_and_round_them(far_reach(make_far_offsets(scale, limit))));
    const std::uint32_t far =
        backend_.lattice_mark_far(lattice_.bricks.view(), active_view_.view(), scale, limit,
                                  lattice_.state.view(), lattice_.values.view(), marks);
    for (const Pending& pending : pending_)
      backend_.relabel_mark(listed(pending), kStuckMark, marks);
    return far + backend_.lattice_mark_narrow(lattice_.bricks.view(), active_view_.view(),
                                              simple_.view(), kLeastWidths, lattice_.state.view(),
                                              lattice_.values.view(), marks);
  }

  /// Leads the field back to the solid round the marks; the octants that this changes are the
  /// active ones from then on: whatever is stuck is marked, so that no label flips elsewhere.
  void repair(View<const std::uint8_t> marks, const Repair& repair) {
    backend_.lattice_blend(lattice_.bricks.view(), marks, repair.radius, repair.strength,
                           repair.smooth, lattice_.state.view(), lattice_.values.view(),
                           active_view_.view());
    backend_.download<std::uint8_t>(active_view_.view(), active_);
  }

 private:
  void collect() {
    const BrickView bricks = lattice_.bricks.view();
    counts_.resize(backend_, 8 * bricks.count + 1);
    const auto counts = counts_.view();
    upload(active_);
    const View<const std::uint8_t> active = active_view_.view();
    backend_.relabel_count(bricks, active, lattice_.state.view(), lattice_.values.view(),
                           counts.subview(0, 8 * bricks.count));
    const std::uint32_t total =
        backend_.exclusive_scan(counts.subview(0, 8 * bricks.count), counts);
    for (Buffer<std::uint32_t>& list : lists_) list.resize(backend_, total);
    backend_.relabel_collect(bricks, active, lattice_.state.view(), lattice_.values.view(), counts,
                             lists_[0].view());
    std::array<std::uint32_t, 9> starts{};
    for (std::size_t colour = 0; colour <= 8; ++colour)
      backend_.download<std::uint32_t>(counts.subview(colour * bricks.count, 1),
                                       {&starts[colour], 1});
    for (std::size_t colour = 0; colour < 8; ++colour)
      pending_[colour] = {starts[colour], starts[colour + 1] - starts[colour], 0};
  }

  View<std::uint32_t> listed(const Pending& pending) {
    return lists_[pending.buffer].view().subview(pending.first, pending.count);
  }

  std::size_t sweep(Pending& pending, float threshold) {
    if (pending.count == 0) return 0;
    const Pending other = {pending.first, pending.count, 1 - pending.buffer};
    const std::size_t left =
        backend_.relabel_sweep(lattice_.bricks.view(), simple_.view(), lattice_.values.view(),
                               threshold, listed(pending), lattice_.state.view(), listed(other));
    const std::size_t flips = pending.count - left;
    if (flips) pending = {other.first, left, other.buffer};
    return flips;
  }

  void upload(std::span<const std::uint8_t> active) {
    active_view_.resize(backend_, active.size());
    backend_.upload(active_view_.view(), active);
  }

  /// The active octants and those up to `reach` from them along each axis.
  std::vector<std::uint8_t> active_and_round_them(const std::array<int, 3>& reach) {
    std::vector<std::uint8_t> grown = active_;
    if (std::all_of(grown.begin(), grown.end(),
                    [](auto octants) { return octants == kAllOctants; }))
      return grown;
    const auto neighbours =
        backend_.on_host(View<const std::int32_t>(lattice_.bricks.neighbours.view()));
    for (std::size_t b = 0; b < active_.size(); ++b)
      for (int octant = 0; octant < 8; ++octant) {
        if (!(active_[b] >> octant & 1)) continue;
        for (int z = (octant >> 2) - reach[2]; z <= (octant >> 2) + reach[2]; ++z)
          for (int y = (octant >> 1 & 1) - reach[1]; y <= (octant >> 1 & 1) + reach[1]; ++y)
            for (int x = (octant & 1) - reach[0]; x <= (octant & 1) + reach[0]; ++x) {
              const int n = brick_neighbour(x >> 1, y >> 1, z >> 1);
              const std::int32_t other = neighbours[27 * b + static_cast<std::size_t>(n)];
              if (other == kNoBrick) continue;
              grown[static_cast<std::size_t>(other)] |=
                  static_cast<std::uint8_t>(1u << ((x & 1) + 2 * (y & 1) + 4 * (z & 1)));
            }
      }
    return grown;
  }

  Backend& backend_;
  Lattice& lattice_;
  std::vector<std::uint8_t> active_;  ///< octants of bricks whose values have changed
  Buffer<std::uint8_t> active_view_;
  Buffer<std::uint8_t> simple_;
  Buffer<std::uint32_t> counts_;
  std::array<Buffer<std::uint32_t>, 2> lists_;
  std::array<Pending, 8> pending_;
};

/// Forgets the boundary faces that a closing has buried: none is to be near the surface again.
void forget_buried_faces(Backend& backend, Lattice& lattice) {
  constexpr float kBuried = 0.2f;
  const auto state = backend.on_host(lattice.state.view());
  const auto values = backend.on_host(View<const float>(lattice.values.view()));
  in_steps(backend, state.size(), [&](std::size_t node) {
    if ((state[node] & kLabel) && values[node] > kBuried)
      state[node] = static_cast<std::uint8_t>(state[node] & ~kFaceCentre);
  });
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
  while (closings && close_handles(backend, lattice, relabelling.stuck(), *closings))
    report.flips += relabelling.run();
  if (closings && !closings->empty()) forget_buried_faces(backend, lattice);
  report.stuck_first = static_cast<std::int64_t>(relabelling.stuck_count());
  for (const Repair& repair : kRepairs) {
    const std::uint32_t marked = relabelling.mark(scale, marks.view());
    if (marked == 0 && relabelling.stuck_count() == 0) break;
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

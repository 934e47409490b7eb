/// Homotopic relabelling and the local repair of the field: kernels/relabel.cl.

#include <numeric>
#include <utility>

#include "opencl/opencl_backend.h"

namespace vasamesh {

void OpenClBackend::relabel_count(const BrickView& bricks, View<const std::uint8_t> active,
                                  View<const std::uint8_t> state, View<const float> values,
                                  View<std::uint32_t> counts) {
  launch("relabel_count", bricks.count, shape_.brick_items, cl_ulong{bricks.count}, active, state,
         values, counts);
}

void OpenClBackend::relabel_collect(const BrickView& bricks, View<const std::uint8_t> active,
                                    View<const std::uint8_t> state, View<const float> values,
                                    View<const std::uint32_t> starts, View<std::uint32_t> nodes) {
  launch("relabel_collect", bricks.count, shape_.brick_items, cl_ulong{bricks.count}, active, state,
         values, starts, nodes);
}

/// Blocks of kNodeBlock nodes; how many each has left is read back, and tells where the block's go.
std::uint32_t OpenClBackend::relabel_sweep(const BrickView& bricks, View<const std::uint8_t> simple,
                                           View<const float> values, float threshold,
                                           View<const std::uint32_t> nodes,
                                           View<std::uint8_t> state, View<std::uint32_t> left) {
  const std::size_t blocks = (nodes.size + kNodeBlock - 1) / kNodeBlock;
  const cl_ulong count = nodes.size;
  const View<std::uint32_t> block_left = counts_of(blocks);
  launch("relabel_sweep", blocks, shape_.brick_items, threshold, count, bricks.neighbours, simple,
         values, nodes, state, block_left);
  std::vector<std::uint32_t> starts(blocks);
  download<std::uint32_t>(block_left, starts);
  std::uint32_t sum = 0;
  for (std::uint32_t& start : starts) sum += std::exchange(start, sum);
  if (sum == count) return sum;
  upload<std::uint32_t>(block_left, starts);
  launch("relabel_compact", blocks, shape_.brick_items, count, values,
         View<const std::uint8_t>(state), nodes, View<const std::uint32_t>(block_left), left);
  return sum;
}

void OpenClBackend::relabel_mark(View<const std::uint32_t> nodes, std::uint8_t mark,
                                 View<std::uint8_t> marks) {
  launch("relabel_mark", groups_of(nodes.size), shape_.fold_items, cl_ulong{nodes.size}, mark,
         nodes, marks);
}

std::uint32_t OpenClBackend::lattice_mark_narrow(
    const BrickView& bricks, View<const std::uint8_t> active, View<const std::uint8_t> simple,
    const LeastWidths& least, View<const std::uint8_t> state, View<const float> values,
    View<std::uint8_t> marks) {
  launch("lattice_mark_narrow", bricks.count, shape_.brick_items, least.across, least.sheet,
         bricks.neighbours, active, simple, state, values, marks, counts_of(bricks.count));
  return sum_of_counts();
}

void OpenClBackend::lattice_blend(const BrickView& bricks, View<const std::uint8_t> marks,
                                  float radius, float strength, bool smooth,
                                  View<const std::uint8_t> state, View<float> values,
                                  View<std::uint8_t> changed) {
  Buffer<std::uint8_t> marked(*this, bricks.count);
  launch("relabel_find_marked", groups_of(bricks.count), shape_.fold_items, cl_ulong{bricks.count},
         marks, marked.view());
  launch("lattice_blend", bricks.count, shape_.brick_items, radius, strength, cl_int{smooth},
         bricks.neighbours, View<const std::uint8_t>(marked.view()), marks, state, values, changed);
}

std::uint32_t OpenClBackend::lattice_clamp(const BrickView& bricks, float least,
                                           View<const std::uint8_t> state, View<float> values) {
  launch("lattice_clamp", bricks.count, shape_.brick_items, least, state, values,
         counts_of(bricks.count));
  return sum_of_counts();
}

View<std::uint32_t> OpenClBackend::counts_of(std::size_t count) {
  counts_.resize(*this, count);
  return counts_.view();
}

std::uint32_t OpenClBackend::sum_of_counts() {
  std::vector<std::uint32_t> counts(counts_.size());
  download<std::uint32_t>(counts_.view(), counts);
  return std::accumulate(counts.begin(), counts.end(), std::uint32_t{0});
}

}  // namespace vasamesh

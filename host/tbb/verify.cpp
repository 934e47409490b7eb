/// The proof's pairs of triangles: leaves of the tree at a time.

#include <algorithm>

#include "stages/candidate_pairs.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kLeaves = 512;  // that a task takes

std::size_t parts_of(std::size_t leaves) { return (leaves + kLeaves - 1) / kLeaves; }

}  // namespace

void TbbBackend::verify_count_pairs(const MeshView& mesh, const TreeView& tree,
                                    View<std::uint32_t> counts) {
  for_each(parts_of(counts.size), 1, [&](std::size_t part) {
    PairSearch search(mesh, tree);
    const std::size_t end = std::min((part + 1) * kLeaves, counts.size);
    for (std::size_t leaf = part * kLeaves; leaf < end; ++leaf)
      counts[leaf] = static_cast<std::uint32_t>(search.search(leaf).size());
  });
}

void TbbBackend::verify_collect_pairs(const MeshView& mesh, const TreeView& tree,
                                      View<const std::uint32_t> starts, View<std::uint32_t> pairs) {
  const std::size_t leaves = starts.size - 1;
  for_each(parts_of(leaves), 1, [&](std::size_t part) {
    PairSearch search(mesh, tree);
    const std::size_t end = std::min((part + 1) * kLeaves, leaves);
    for (std::size_t leaf = part * kLeaves; leaf < end; ++leaf) {
      if (starts[leaf + 1] == starts[leaf]) continue;
      std::uint32_t* to = &pairs[2 * std::size_t{starts[leaf]}];
      for (const PairSearch::Pair& pair : search.search(leaf)) to = std::copy_n(pair.data(), 2, to);
    }
  });
}

}  // namespace vasamesh

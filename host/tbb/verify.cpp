/// The proof's pairs of triangles: leaves of the tree at a time.

#include <algorithm>

#include "backend/ranges.h"
#include "stages/candidate_pairs.h"
#include "tbb/tbb_backend.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 512;  // leaves a task takes

}  // namespace

void TbbBackend::verify_count_pairs(const MeshView& mesh, const TreeView& tree,
                                    View<std::uint32_t> counts) {
  for_each_range(*this, counts.size, kGrain, [&](std::size_t begin, std::size_t end) {
    PairSearch search(mesh, tree);
    for (std::size_t leaf = begin; leaf < end; ++leaf)
      counts[leaf] = static_cast<std::uint32_t>(search.search(leaf).size());
  });
}

void TbbBackend::verify_collect_pairs(const MeshView& mesh, const TreeView& tree,
                                      View<const std::uint32_t> starts, View<std::uint32_t> pairs) {
  for_each_range(*this, starts.size - 1, kGrain, [&](std::size_t begin, std::size_t end) {
    PairSearch search(mesh, tree);
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      if (starts[leaf + 1] == starts[leaf]) continue;
      std::uint32_t* to = &pairs[2 * std::size_t{starts[leaf]}];
      for (const PairSearch::Pair& pair : search.search(leaf)) to = std::copy_n(pair.data(), 2, to);
    }
  });
}

}  // namespace vasamesh

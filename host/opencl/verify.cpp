/// The proof's pairs of triangles: kernels/verify.cl.

#include "opencl/opencl_backend.h"

namespace vasamesh {

static_assert(sizeof(BoxNode) == 48 * sizeof(float), "VERIFY_NODE of kernels/verify.cl");

void OpenClBackend::verify_count_pairs(const MeshView& mesh, const TreeView& tree,
                                       View<std::uint32_t> counts) {
  launch("verify_count_pairs", groups_of(counts.size), shape_.fold_items, cl_ulong{counts.size},
         mesh.vertices, mesh.triangles, tree, counts);
}

void OpenClBackend::verify_collect_pairs(const MeshView& mesh, const TreeView& tree,
                                         View<const std::uint32_t> starts,
                                         View<std::uint32_t> pairs) {
  const std::size_t leaves = starts.size - 1;
  launch("verify_collect_pairs", groups_of(leaves), shape_.fold_items, cl_ulong{leaves},
         mesh.vertices, mesh.triangles, tree, starts, pairs);
}

}  // namespace vasamesh

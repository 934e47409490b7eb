/// Collapses of short edges.

#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

/// Whether the triangles and edges that `kept` gets when `gone` is merged into it keep the rules.
bool leaves_good_triangles(const PatchMesh& mesh, std::uint32_t gone, std::uint32_t kept,
                           float longest) {
  const SurfacePoint &point = mesh.points[kept], &old = mesh.points[gone];
  const auto is_good_edge = [&](const SurfacePoint& to) {
    return relative_length(point, to) <= longest * longest && edge_follows(point, to);
  };
  std::uint32_t last = kept;  // the last corner of a triangle that stays, whose edge is good
  return mesh.all_out(gone, [&](std::uint32_t h) {
    const std::uint32_t b = mesh.target(h), c = mesh.apex(h);
    if (b == kept || c == kept) return true;
    const SurfacePoint &p = mesh.points[b], &q = mesh.points[c];
    if ((b != last && !is_good_edge(p)) || !is_good_edge(q)) return false;
    last = c;
    return triangle_quality(point, p, q) >= kSquaredSine10 ||
           may_replace(old, point, p, q, std::min(kSquaredSine10, facing_fan_quality(mesh, gone)));
  });
}

/// Merges v along its shortest edge that may go. \return whether it did.
bool merge_vertex(PatchMesh& mesh, std::uint32_t v, float shortest, float longest) {
  struct Candidate {
    float length;
    std::uint32_t edge, kept;
  };
  constexpr int kMost = 8;
  Candidate candidates[kMost];
  int count = 0;
  const auto consider = [&](std::uint32_t h, std::uint32_t w) {
    const float length = relative_length(mesh.points[v], mesh.points[w]);
    if (!(length < shortest * shortest) || count == kMost || !mesh.is_whole(w)) return;
    int i = count++;
    for (; i > 0 && candidates[i - 1].length > length; --i) candidates[i] = candidates[i - 1];
    candidates[i] = {length, h, w};
  };
  mesh.for_each_out(v, [&](std::uint32_t h) {
    consider(h, mesh.target(h));
    const std::uint32_t in = PatchMesh::previous(h);
    if (mesh.twin(in) == PatchMesh::kNone) consider(in, mesh.apex(h));
  });
  for (int i = 0; i < count; ++i) {
    const Candidate& c = candidates[i];
    if (!leaves_good_triangles(mesh, v, c.kept, longest) || !mesh.may_collapse(c.edge, v, c.kept))
      continue;
    mesh.collapse(c.edge, v, c.kept);
    return true;
  }
  return false;
}

}  // namespace

void collapse_short_edges(PatchMesh& mesh, float shortest, float longest) {
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.take_turn();
    if (mesh.is_there(v) && mesh.is_whole(v)) merge_vertex(mesh, v, shortest, longest);
  }
}

}  // namespace vasamesh

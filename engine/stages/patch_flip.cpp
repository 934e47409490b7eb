/// Flips of edges.

#include <vector>

#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

/// The two triangles at an edge before and after its flip: the least quality of each pair.
struct FlipQuality {
  float before, after;
};

FlipQuality flip_quality(const PatchMesh& mesh, std::uint32_t h) {
  const SurfacePoint& p = mesh.points[mesh.origin(h)];
  const SurfacePoint& q = mesh.points[mesh.target(h)];
  const SurfacePoint& c = mesh.points[mesh.apex(h)];
  const SurfacePoint& d = mesh.points[mesh.apex(mesh.twin(h))];
  FlipQuality quality;
  quality.before = std::min(triangle_quality(p, q, c), triangle_quality(q, p, d));
  quality.after = std::min(triangle_quality(d, c, p), triangle_quality(c, d, q));
  if (!edge_follows(c, d)) quality.after = -2;
  return quality;
}

/// How far whole vertices are from the right numbers of edges: six, or four on borders.
class Excesses {
 public:
  explicit Excesses(const PatchMesh& mesh) : mesh_(mesh), of_(mesh.vertex_count(), 0) {
    for (std::uint32_t h = 0; h < mesh.half_edge_end(); ++h)
      if (mesh.is_edge(h)) ++of_[mesh.origin(h)];
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.is_there(v) && mesh.is_whole(v)) of_[v] -= mesh.is_border(v) ? 3 : 6;
  }

  /// Whether the sum of their squares becomes less by a flip.
  bool gain_by_flip(std::uint32_t h) const {
    return of_[mesh_.origin(h)] + of_[mesh_.target(h)] >
           of_[mesh_.apex(h)] + of_[mesh_.apex(mesh_.twin(h))] + 2;
  }

  /// \pre the edge has been flipped.
  void take_flip(std::uint32_t h) {
    ++of_[mesh_.origin(h)];
    ++of_[mesh_.target(h)];
    --of_[mesh_.apex(h)];
    --of_[mesh_.apex(mesh_.twin(h))];
  }

 private:
  const PatchMesh& mesh_;
  std::vector<int> of_;
};

bool all_whole(const PatchMesh& mesh, std::uint32_t h) {
  return mesh.is_whole(mesh.origin(h)) && mesh.is_whole(mesh.target(h)) &&
         mesh.is_whole(mesh.apex(h)) && mesh.is_whole(mesh.apex(mesh.twin(h)));
}

/// Flips the edges for which wanted(h) says so, pass after pass, and calls flipped(h) then. The
/// half-edge of lower index stands for its edge.
template <class Wanted, class Flipped>
void flip_where(PatchMesh& mesh, int passes, const Wanted& wanted, const Flipped& flipped) {
  for (int pass = 0; pass < passes; ++pass) {
    bool any = false;
    for (std::uint32_t h = 0; h < mesh.half_edge_end(); ++h) {
      mesh.take_turn();
      if (!mesh.is_edge(h) || mesh.twin(h) == PatchMesh::kNone || mesh.twin(h) < h) continue;
      if (!all_whole(mesh, h) || !wanted(h) || !mesh.may_flip(h)) continue;
      mesh.flip(h);
      flipped(h);
      any = true;
    }
    if (!any) return;
  }
}

}  // namespace

void flip_to_valence(PatchMesh& mesh, int passes) {
  Excesses excesses(mesh);
  const auto wanted = [&](std::uint32_t h) {
    if (!excesses.gain_by_flip(h)) return false;
    const FlipQuality quality = flip_quality(mesh, h);
    return quality.after >= kSquaredSine20 ||
           (quality.after >= 0 && quality.after > quality.before);
  };
  flip_where(mesh, passes, wanted, [&](std::uint32_t h) { excesses.take_flip(h); });
}

void flip_to_angle(PatchMesh& mesh, int passes) {
  const auto wanted = [&](std::uint32_t h) {
    const FlipQuality quality = flip_quality(mesh, h);
    return quality.after >= 0 && quality.after > 1.02f * quality.before;
  };
  flip_where(mesh, passes, wanted, [](std::uint32_t) {});
}

}  // namespace vasamesh

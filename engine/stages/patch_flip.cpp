/// Flips of edges.

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

int edges_at(const PatchMesh& mesh, std::uint32_t v) {
  return mesh.fan_size(v) + (mesh.is_border(v) ? 1 : 0);
}

/// How far from the right number of edges.
int excess(const PatchMesh& mesh, std::uint32_t v) {
  return edges_at(mesh, v) - (mesh.is_border(v) ? 4 : 6);
}

/// How much less the sum of squares of the excesses becomes.
int valence_gain(const PatchMesh& mesh, std::uint32_t h) {
  const int p = excess(mesh, mesh.origin(h)), q = excess(mesh, mesh.target(h)),
            c = excess(mesh, mesh.apex(h)), d = excess(mesh, mesh.apex(mesh.twin(h)));
  const auto square = [](int x) { return x * x; };
  return square(p) + square(q) + square(c) + square(d) - square(p - 1) - square(q - 1) -
         square(c + 1) - square(d + 1);
}

bool all_whole(const PatchMesh& mesh, std::uint32_t h) {
  return mesh.is_whole(mesh.origin(h)) && mesh.is_whole(mesh.target(h)) &&
         mesh.is_whole(mesh.apex(h)) && mesh.is_whole(mesh.apex(mesh.twin(h)));
}

/// Flips the edges for which wanted(h) says so, pass after pass. The half-edge of lower index
/// stands for its edge.
template <class Wanted>
void flip_where(PatchMesh& mesh, int passes, const Wanted& wanted) {
  for (int pass = 0; pass < passes; ++pass) {
    bool any = false;
    for (std::uint32_t h = 0; h < mesh.half_edge_end(); ++h) {
      if (!mesh.is_edge(h) || mesh.twin(h) == PatchMesh::kNone || mesh.twin(h) < h) continue;
      if (!all_whole(mesh, h) || !wanted(h) || !mesh.may_flip(h)) continue;
      mesh.flip(h);
      any = true;
    }
    if (!any) return;
  }
}

}  // namespace

void flip_to_valence(PatchMesh& mesh, int passes) {
  flip_where(mesh, passes, [&](std::uint32_t h) {
    if (valence_gain(mesh, h) <= 0) return false;
    const FlipQuality quality = flip_quality(mesh, h);
    return quality.after >= kSine20 || (quality.after >= 0 && quality.after > quality.before);
  });
}

void flip_to_angle(PatchMesh& mesh, int passes) {
  flip_where(mesh, passes, [&](std::uint32_t h) {
    const FlipQuality quality = flip_quality(mesh, h);
    return quality.after >= 0 && quality.after > 1.02f * quality.before;
  });
}

}  // namespace vasamesh

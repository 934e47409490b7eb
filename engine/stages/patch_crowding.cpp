#include "stages/patch_crowding.h"

#include <algorithm>

#include "types/cell_hash.h"

namespace vasamesh {

namespace {

constexpr std::uint32_t kNone = PatchMesh::kNone;
constexpr float kNear = 1.2f;   // longest edges
constexpr float kAlike = 0.5f;  // cosine between the normals of one sheet, or more

float longest_edge(const PatchMesh& mesh, std::uint32_t v) {
  const Vec3& p = mesh.points[v].position;
  float longest = 0;
  mesh.for_each_out(v, [&](std::uint32_t h) {
    for (const std::uint32_t w : {mesh.target(h), mesh.apex(h)})
      longest = std::max(longest, squared_norm(mesh.points[w].position - p));
  });
  return std::sqrt(longest);
}

/// The vertices of a part by the cells of a grid.
class VertexGrid {
 public:
  VertexGrid(const PatchMesh& mesh, float side)
      : mesh_(mesh),
        cells_(1 / side, mesh.vertex_count()),
        head_(cells_.slots(), kNone),
        next_(mesh.vertex_count(), kNone) {
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      if (!mesh.is_there(v)) continue;
      std::uint32_t& head = head_[cells_.slot_of(mesh.points[v].position)];
      next_[v] = head;
      head = v;
    }
  }

  /// visit(w) for all vertices within `reach` of a point, some of them twice.
  template <class Visit>
  void for_each_near(const Vec3& p, float reach, const Visit& visit) const {
    cells_.for_each_slot(Box{p, p}.widened(reach), [&](std::uint32_t slot) {
      for (std::uint32_t w = head_[slot]; w != kNone; w = next_[w])
        if (squared_norm(mesh_.points[w].position - p) <= reach * reach) visit(w);
    });
  }

 private:
  const PatchMesh& mesh_;
  CellHash cells_;
  std::vector<std::uint32_t> head_, next_;
};

/// How far to look for others at each whole vertex; 0 at the rest.
std::vector<float> reaches(const PatchMesh& mesh) {
  std::vector<float> reach(mesh.vertex_count(), 0.0f);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.is_there(v) && mesh.is_whole(v)) {
      mesh.take_turn();
      reach[v] = kNear * longest_edge(mesh, v);
    }
  return reach;
}

float mean_reach(const std::vector<float>& reach) {
  float sum = 0, count = 0;
  for (const float r : reach)
    if (r > 0) sum += r, ++count;
  return count > 0 ? sum / count : 1.0f;
}

/// Which vertices are within two edges of one.
class TwoRings {
 public:
  explicit TwoRings(const PatchMesh& mesh) : mesh_(mesh), mark_(mesh.vertex_count(), kNone) {}

  /// \pre v is whole.
  void centre(std::uint32_t v) {
    centre_ = v;
    mesh_.for_each_out(v,
                       [&](std::uint32_t h) { mark_[mesh_.target(h)] = mark_[mesh_.apex(h)] = v; });
  }

  /// Whether w is one; false where w is neither whole nor joined to the centre.
  bool hold(std::uint32_t w) const {
    const auto is_near = [&](std::uint32_t u) { return u == centre_ || mark_[u] == centre_; };
    if (is_near(w)) return true;
    return mesh_.is_whole(w) && !mesh_.all_out(w, [&](std::uint32_t h) {
      return !is_near(mesh_.target(h)) && !is_near(mesh_.apex(h));
    });
  }

 private:
  const PatchMesh& mesh_;
  std::vector<std::uint32_t> mark_;
  std::uint32_t centre_ = kNone;
};

}  // namespace

std::vector<std::uint8_t> crowded_vertices(const PatchMesh& mesh) {
  const std::vector<float> reach = reaches(mesh);
  const VertexGrid grid(mesh, mean_reach(reach));
  std::vector<std::uint8_t> crowded(mesh.vertex_count(), 0);
  TwoRings rings(mesh);
  std::vector<std::uint32_t> others;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    mesh.take_turn();
    const SurfacePoint& p = mesh.points[v];
    if (reach[v] == 0) continue;
    others.clear();
    if (!p.on_field) crowded[v] = 1;
    grid.for_each_near(p.position, reach[v], [&](std::uint32_t w) {
      const SurfacePoint& q = mesh.points[w];
      if (!p.on_field || !q.on_field)
        crowded[v] = crowded[w] = 1;
      else if (dot(p.normal, q.normal) < kAlike)
        others.push_back(w);
    });
    if (others.empty()) continue;
    rings.centre(v);
    for (const std::uint32_t w : others)
      if (!rings.hold(w)) crowded[v] = crowded[w] = 1;
  }
  return crowded;
}

}  // namespace vasamesh

#include "stages/gap_rim.h"

#include <algorithm>

#include "backend/ranges.h"
#include "stages/gap_rules.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kTriangleGrain = 16384, kVertexGrain = 1024, kLoopGrain = 256;

}  // namespace

GapRim::GapRim(Backend& backend, const FieldView& field, const TriangleMesh& mesh,
               const GapLoops& loops) {
  number_vertices(mesh, loops);
  collect_edges(backend, mesh);
  check_loops(backend, loops);
  find_normals(backend, field, mesh);
}

void GapRim::number_vertices(const TriangleMesh& mesh, const GapLoops& loops) {
  slot_.assign(mesh.vertex_count(), kNoVertex);
  for (std::uint32_t v : loops.vertex) {
    if (slot_[v] != kNoVertex) continue;
    slot_[v] = static_cast<std::uint32_t>(vertex_.size());
    vertex_.push_back(v);
  }
}

void GapRim::collect_edges(Backend& backend, const TriangleMesh& mesh) {
  struct Edge {
    std::uint32_t slot;
    Spoke spoke;
  };
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<Edge>& found) {
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t* v = mesh.triangles.data() + 3 * t;
      const std::uint32_t slot[3] = {slot_[v[0]], slot_[v[1]], slot_[v[2]]};
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        if (slot[i] == kNoVertex || slot[j] == kNoVertex) continue;
        found.push_back({slot[i], {v[j], kNoVertex}});
        found.push_back({slot[j], {v[i], v[k]}});
      }
    }
  };
  const std::vector<Edge> edges =
      collect<Edge>(backend, mesh.triangle_count(), kTriangleGrain, find);
  first_.assign(vertex_.size() + 2, 0);
  for (const Edge& edge : edges) ++first_[edge.slot + 2];
  for (std::size_t s = 2; s < first_.size(); ++s) first_[s] += first_[s - 1];
  spokes_.resize(first_.back());
  for (const Edge& edge : edges) spokes_[first_[edge.slot + 1]++] = edge.spoke;
  first_.pop_back();
}

void GapRim::check_loops(Backend& backend, const GapLoops& loops) const {
  for_each_index(backend, loops.count(), kLoopGrain, [&](std::size_t l) {
    for (std::size_t i = 0; i < loops.size(l); ++i) {
      const std::uint32_t a = loops[l][i], b = loops[l][(i + 1) % loops.size(l)];
      if (across(a, b) == kNoVertex || across(b, a) != kNoVertex)
        throw Error(ErrorCode::internal, "gaps: an edge of a loop is not on the boundary");
    }
  });
}

void GapRim::find_normals(Backend& backend, const FieldView& field, const TriangleMesh& mesh) {
  normals_.resize(vertex_.size());
  for_each_index(backend, vertex_.size(), kVertexGrain, [&](std::size_t s) {
    const FieldSample sample = sample_field(field, vertex_at(mesh, vertex_[s]));
    const bool usable = sample.known && squared_norm(sample.gradient) > 0;
    normals_[s] = normalised(usable ? -sample.gradient : normal_of_triangles(mesh, s));
  });
}

/// The sum over the triangles that have two rim vertices, one of them this.
Vec3 GapRim::normal_of_triangles(const TriangleMesh& mesh, std::size_t slot) const {
  const Vec3 at = vertex_at(mesh, vertex_[slot]);
  Vec3 sum;
  for (std::uint32_t i = first_[slot]; i < first_[slot + 1]; ++i)
    if (spokes_[i].apex != kNoVertex)
      sum = sum + cross(vertex_at(mesh, spokes_[i].apex) - at, vertex_at(mesh, spokes_[i].to) - at);
  return sum;
}

bool GapRim::has_edge(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t slot = slot_[a];
  for (std::uint32_t i = first_[slot]; i < first_[slot + 1]; ++i)
    if (spokes_[i].to == b) return true;
  return std::any_of(added_.begin(), added_.end(), [&](const Added& e) {
    return (e.a == a && e.b == b) || (e.a == b && e.b == a);
  });
}

std::uint32_t GapRim::across(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t slot = slot_[a];
  for (std::uint32_t i = first_[slot]; i < first_[slot + 1]; ++i)
    if (spokes_[i].to == b && spokes_[i].apex != kNoVertex) return spokes_[i].apex;
  for (const Added& edge : added_)
    if (edge.a == a && edge.b == b) return edge.apex;
  return kNoVertex;
}

void GapRim::add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t apex) {
  added_.push_back({a, b, apex});
}

}  // namespace vasamesh

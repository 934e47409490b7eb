#include "stages/patch_mesh.h"

#include <utility>

#include "backend/backend.h"

namespace vasamesh {

namespace {

/// The half-edges with `low` as their lower end are slot[first[low]] .. slot[first[low + 1] - 1].
struct EdgesByLowerEnd {
  std::vector<std::uint32_t> first, slot;
};

EdgesByLowerEnd sort_edges(const std::vector<std::uint32_t>& corners, std::size_t vertices) {
  EdgesByLowerEnd result;
  result.first.assign(vertices + 2, 0);
  const auto lower_end = [&](std::size_t c) {
    const std::size_t other = c % 3 == 2 ? c - 2 : c + 1;
    return corners[c] < corners[other] ? corners[c] : corners[other];
  };
  for (std::size_t c = 0; c < corners.size(); ++c) ++result.first[lower_end(c) + 2];
  for (std::size_t v = 2; v < result.first.size(); ++v) result.first[v] += result.first[v - 1];
  result.slot.resize(corners.size());
  for (std::size_t c = 0; c < corners.size(); ++c)
    result.slot[result.first[lower_end(c) + 1]++] = static_cast<std::uint32_t>(c / 3 * 4 + c % 3);
  return result;
}

}  // namespace

void PatchMesh::build(std::vector<SurfacePoint> given, const std::vector<std::uint32_t>& corners,
                      std::vector<std::uint8_t> whole) {
  points = std::move(given);
  whole_ = std::move(whole);
  const std::size_t triangles = corners.size() / 3;
  origin_.assign(4 * triangles, kNone);
  twin_.assign(4 * triangles, kNone);
  edge_.assign(points.size(), kNone);
  mark_.assign(points.size(), 0);
  stamp_ = 0;
  for (std::size_t c = 0; c < corners.size(); ++c) origin_[c / 3 * 4 + c % 3] = corners[c];

  const EdgesByLowerEnd edges = sort_edges(corners, points.size());
  for (std::size_t v = 0; v < points.size(); ++v)
    for (std::uint32_t i = edges.first[v]; i < edges.first[v + 1]; ++i) {
      const std::uint32_t h = edges.slot[i];
      if (twin_[h] != kNone) continue;
      for (std::uint32_t j = i + 1; j < edges.first[v + 1]; ++j) {
        const std::uint32_t g = edges.slot[j];
        if (origin_[g] != target(h) || target(g) != origin_[h]) continue;
        link(h, g);
        break;
      }
    }
  for (std::uint32_t h = 0; h < half_edge_end(); ++h) {
    if (!is_edge(h)) continue;
    std::uint32_t& out = edge_[origin_[h]];
    if (out == kNone || twin_[h] == kNone) out = h;
  }
}

int PatchMesh::fan_size(std::uint32_t v) const {
  int size = 0;
  for_each_out(v, [&](std::uint32_t) { ++size; });
  return size;
}

bool PatchMesh::are_joined(std::uint32_t from, std::uint32_t to) const {
  bool joined = false;
  for_each_out(from, [&](std::uint32_t h) { joined |= target(h) == to || apex(h) == to; });
  return joined;
}

/// With `border` a border half-edge: whether its loop has no more than kLeastLoop edges, or comes
/// to a vertex that is not whole before that is known.
bool PatchMesh::loop_is_short(std::uint32_t border) const {
  std::uint32_t h = border;
  for (int i = 0; i < kLeastLoop; ++i) {
    const std::uint32_t v = target(h);
    if (!is_whole(v)) return true;
    h = edge_[v];
    if (h == border) return true;
  }
  return false;
}

void PatchMesh::ask_backend() const {
  if (backend_) backend_->checkpoint();
}

void PatchMesh::hold_border() {
  for (std::uint32_t v = 0; v < vertex_count(); ++v)
    if (is_there(v) && is_whole(v) && is_border(v)) whole_[v] = 0;
}

bool PatchMesh::may_collapse(std::uint32_t h, std::uint32_t gone, std::uint32_t kept) {
  if (!is_whole(gone) || !is_whole(kept)) return false;
  const std::uint32_t t = twin_[h];
  const bool border_edge = t == kNone;
  if (is_border(gone) && (!border_edge || loop_is_short(h))) return false;

  // The links of both ends may share the apexes of the edge's triangles, and no edge.
  ++stamp_;
  int gone_size = 0, kept_size = 0, common = 0;
  for_each_out(gone, [&](std::uint32_t g) {
    mark_[target(g)] = mark_[apex(g)] = stamp_;
    ++gone_size;
  });
  for_each_out(kept, [&](std::uint32_t g) {
    common += mark_[target(g)] == stamp_;
    ++kept_size;
  });
  if (is_border(kept)) {
    // The last edge of a border fan is no half-edge out of the vertex.
    std::uint32_t last = edge_[kept];
    while (twin_[previous(last)] != kNone) last = twin_[previous(last)];
    common += mark_[apex(last)] == stamp_;
  }
  if (border_edge) return common == 1 && gone_size + kept_size > 2;
  return common == 2 && (gone_size > 3 || kept_size > 3) && may_lose_triangle(apex(h)) &&
         may_lose_triangle(apex(t)) && (is_border(kept) || gone_size + kept_size >= 4 + kLeastFan);
}

bool PatchMesh::may_lose_triangle(std::uint32_t v) const {
  return !is_inner(v) || fan_size(v) > kLeastFan;
}

void PatchMesh::link(std::uint32_t a, std::uint32_t b) {
  if (a != kNone) twin_[a] = b;
  if (b != kNone) twin_[b] = a;
}

/// Makes h, or on a border the border half-edge that it turns back to, the one that v starts from.
void PatchMesh::set_edge(std::uint32_t v, std::uint32_t h) {
  std::uint32_t g = h;
  while (twin_[g] != kNone) {
    g = next(twin_[g]);
    if (g == h) break;
  }
  edge_[v] = g;
}

void PatchMesh::remove_triangle(std::uint32_t h) {
  const std::uint32_t first = h & ~3u;
  for (std::uint32_t i = 0; i < 3; ++i) origin_[first + i] = twin_[first + i] = kNone;
}

void PatchMesh::collapse(std::uint32_t h, std::uint32_t gone, std::uint32_t kept) {
  const std::uint32_t sides[2] = {h, twin_[h]};
  const auto in_side = [&](std::uint32_t g) {
    return (g & ~3u) == (sides[0] & ~3u) || (sides[1] != kNone && (g & ~3u) == (sides[1] & ~3u));
  };
  // Outer half-edges into the vertices from which apexes and `kept` can start anew.
  std::uint32_t apexes[2] = {kNone, kNone}, apex_out[2] = {kNone, kNone}, kept_out = kNone;
  const std::uint32_t old_kept_edge = edge_[kept];
  const bool border = is_border(gone) || is_border(kept);
  for (std::uint32_t g = edge_[gone], first = g;;) {
    origin_[g] = kept;
    g = twin_[previous(g)];
    if (g == first || g == kNone) break;
  }
  for (int s = 0; s < 2 && sides[s] != kNone; ++s) {
    const std::uint32_t to_apex = next(sides[s]), from_apex = previous(sides[s]);
    const std::uint32_t a = twin_[to_apex], b = twin_[from_apex];  // apex -> kept, kept -> apex
    link(a, b);
    apexes[s] = origin_[from_apex];
    apex_out[s] = a != kNone ? a : next(b);
    if (kept_out == kNone) kept_out = b != kNone ? b : next(a);
  }
  for (int s = 0; s < 2 && sides[s] != kNone; ++s)
    if (in_side(edge_[apexes[s]])) set_edge(apexes[s], apex_out[s]);
  for (int s = 0; s < 2 && sides[s] != kNone; ++s) remove_triangle(sides[s]);
  if (border || in_side(old_kept_edge)) set_edge(kept, kept_out);
  edge_[gone] = kNone;
}

std::uint32_t PatchMesh::split(std::uint32_t h, const SurfacePoint& point) {
  const std::uint32_t m = vertex_count();
  const std::uint32_t q = target(h), c = apex(h), n = next(h), t = twin_[h];
  points.push_back(point);
  edge_.push_back(kNone);
  whole_.push_back(1);
  mark_.push_back(0);

  // (p, q, c) becomes (p, m, c) and (m, q, c).
  const std::uint32_t e = half_edge_end();
  origin_.insert(origin_.end(), {m, q, c, kNone});
  twin_.insert(twin_.end(), 4, kNone);
  link(e + 1, twin_[n]);
  link(e + 2, n);
  origin_[n] = m;
  if (edge_[q] == n) edge_[q] = e + 1;
  edge_[m] = e;
  if (t == kNone) return m;

  // (q, p, d) becomes (m, p, d) and (q, m, d).
  const std::uint32_t r = previous(t), d = origin_[r];
  const std::uint32_t f = half_edge_end();
  origin_.insert(origin_.end(), {q, m, d, kNone});
  twin_.insert(twin_.end(), 4, kNone);
  link(f + 2, twin_[r]);
  link(f + 1, r);
  link(e, f);
  origin_[t] = m;
  if (edge_[q] == t) edge_[q] = f;
  if (edge_[d] == r) edge_[d] = f + 2;
  return m;
}

bool PatchMesh::may_flip(std::uint32_t h) const {
  const std::uint32_t t = twin_[h];
  if (t == kNone) return false;
  const std::uint32_t c = apex(h), d = apex(t);
  return is_whole(origin_[h]) && is_whole(target(h)) && is_whole(c) && is_whole(d) && c != d &&
         !are_joined(c, d);
}

void PatchMesh::flip(std::uint32_t h) {
  const std::uint32_t t = twin_[h];
  const std::uint32_t n = next(h), r = previous(h), n1 = next(t), r1 = previous(t);
  const std::uint32_t p = origin_[h], q = origin_[t], c = origin_[r], d = origin_[r1];
  const std::uint32_t qc = twin_[n], cp = twin_[r], pd = twin_[n1], dq = twin_[r1];
  // (p, q, c), (q, p, d) become (d, c, p), (c, d, q), in the same places.
  origin_[h] = d, origin_[n] = c, origin_[r] = p;
  origin_[t] = c, origin_[n1] = d, origin_[r1] = q;
  twin_[n] = twin_[r] = twin_[n1] = twin_[r1] = kNone;
  link(n, cp);
  link(r, pd);
  link(n1, dq);
  link(r1, qc);
  if (edge_[p] == h || edge_[p] == n1) edge_[p] = r;
  if (edge_[q] == t || edge_[q] == n) edge_[q] = r1;
  if (edge_[c] == r) edge_[c] = n;
  if (edge_[d] == r1) edge_[d] = n1;
}

}  // namespace vasamesh

#include "stages/manifold.h"

#include <algorithm>

#include "backend/ranges.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16384;  // vertices a task takes
constexpr std::size_t kSmallFan = 32;  // corners up to which a fan is searched, not sorted

/// The edge of a triangle across from a vertex, from `next` to `previous`.
struct Spoke {
  std::uint32_t next, previous;
};

/// One end of a triangle's edge at the vertex.
struct End {
  std::uint32_t vertex, spoke;
  bool leaving;  ///< the triangle traverses the edge away from the vertex
};

/// What is found round one vertex at a time.
class FanCounter {
 public:
  explicit FanCounter(const TriangleMesh& mesh) : mesh_(mesh) {}

  ManifoldCounts counts;  ///< edges_up stays empty

  /// \return the edges to vertices above `vertex`.
  std::uint32_t count(std::uint32_t vertex, const std::uint32_t* first, const std::uint32_t* last) {
    spokes_.clear();
    for (; first != last; ++first) add_spoke(*first);
    if (spokes_.empty()) ++counts.isolated_vertices;
    if (spokes_.empty() || is_closed_fan()) return edges_above(vertex);
    return count_defects(vertex);
  }

 private:
  void add_spoke(std::uint32_t corner) {
    const std::uint32_t* t = mesh_.triangles.data() + corner / 3 * 3;
    const std::uint32_t v = t[corner % 3], next = t[(corner + 1) % 3],
                        previous = t[(corner + 2) % 3];
    if (v != next && v != previous && next != previous) spokes_.push_back({next, previous});
  }

  /// Walks from triangle to triangle round the vertex: right when the walk comes back after all.
  bool is_closed_fan() const {
    const std::size_t count = spokes_.size();
    if (count > kSmallFan) return false;
    std::size_t at = 0;
    for (std::size_t step = 1; step <= count; ++step) {
      std::size_t across = 0;
      while (across < count && spokes_[across].previous != spokes_[at].next) ++across;
      if (across == count) return false;
      if (across == 0) return step == count;
      at = across;
    }
    return false;
  }

  std::uint32_t edges_above(std::uint32_t vertex) const {
    std::uint32_t edges = 0;
    for (const Spoke& spoke : spokes_) edges += spoke.next > vertex;
    return edges;
  }

  std::uint32_t count_defects(std::uint32_t vertex) {
    ends_.clear();
    fan_.resize(spokes_.size());
    for (std::uint32_t s = 0; s < spokes_.size(); ++s) {
      ends_.push_back({spokes_[s].next, s, true});
      ends_.push_back({spokes_[s].previous, s, false});
      fan_[s] = s;
    }
    std::sort(ends_.begin(), ends_.end(), [](const End& a, const End& b) {
      return a.vertex != b.vertex ? a.vertex < b.vertex : a.spoke < b.spoke;
    });
    std::uint32_t edges = 0;
    std::size_t fans = spokes_.size();
    for (std::size_t first = 0, last; first < ends_.size(); first = last) {
      int leaving = 0;
      for (last = first; last < ends_.size() && ends_[last].vertex == ends_[first].vertex; ++last) {
        leaving += ends_[last].leaving;
        fans -= join(ends_[first].spoke, ends_[last].spoke);
      }
      if (ends_[first].vertex < vertex) continue;
      ++edges;
      count_edge(last - first, leaving);
    }
    counts.nonmanifold_vertices += fans > 1;
    return edges;
  }

  void count_edge(std::size_t triangles, int leaving) {
    counts.open_edges += triangles == 1;
    counts.nonmanifold_edges += triangles > 2;
    counts.misoriented_edges += triangles == 2 && leaving != 1;
  }

  /// Joins the fans of two triangles. \return whether they were two.
  bool join(std::uint32_t a, std::uint32_t b) {
    while (fan_[a] != a) a = fan_[a] = fan_[fan_[a]];
    while (fan_[b] != b) b = fan_[b] = fan_[fan_[b]];
    fan_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

  const TriangleMesh& mesh_;
  std::vector<Spoke> spokes_;
  std::vector<End> ends_;
  std::vector<std::uint32_t> fan_;
};

void add(ManifoldCounts& sum, const ManifoldCounts& part) {
  sum.open_edges += part.open_edges;
  sum.nonmanifold_edges += part.nonmanifold_edges;
  sum.misoriented_edges += part.misoriented_edges;
  sum.nonmanifold_vertices += part.nonmanifold_vertices;
  sum.isolated_vertices += part.isolated_vertices;
}

}  // namespace

ManifoldCounts count_manifold(Backend& backend, const TriangleMesh& mesh,
                              const VertexCorners& corners) {
  const std::size_t vertices = mesh.vertex_count();
  ManifoldCounts total;
  total.edges_up.resize(vertices);
  const auto count = [&](std::size_t begin, std::size_t end) {
    FanCounter counter(mesh);
    for (std::size_t v = begin; v < end; ++v)
      total.edges_up[v] =
          counter.count(static_cast<std::uint32_t>(v), corners.corner.data() + corners.first[v],
                        corners.corner.data() + corners.first[v + 1]);
    return counter.counts;
  };
  for (const ManifoldCounts& part : map_ranges(backend, vertices, kGrain, count)) add(total, part);
  return total;
}

}  // namespace vasamesh

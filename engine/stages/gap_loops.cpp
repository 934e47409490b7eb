#include "stages/gap_loops.h"

#include <algorithm>
#include <array>

#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "types/angles.h"
#include "types/mesh_vertex.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 16384;  // vertices a task takes
constexpr std::uint32_t kNone = 0xffffffffu;

/// A gap's corner: the loop goes previous -> vertex -> next.
struct Corner {
  std::uint32_t vertex, previous, next;
};

/// Fans of triangles round one vertex and the corners of the gaps between them.
class CornerFinder {
 public:
  CornerFinder(const TriangleMesh& mesh, const VertexCorners& corners)
      : mesh_(mesh), corners_(corners) {}

  void find(std::uint32_t vertex, std::vector<Corner>& found) {
    collect_spokes(vertex);
    fans_.clear();
    for (const Spoke& spoke : spokes_)
      if (leaving_from(spoke.next) == kNone) fans_.push_back({spoke.next, end_of_fan(spoke), 0});
    if (fans_.empty()) return;
    refuse_repeated_edges();
    if (fans_.size() > 1) sort_by_angle(vertex);
    // From the end of a fan, counter-clockwise, the gap reaches the start of the next.
    corners_here_.clear();
    for (std::size_t f = 0; f < fans_.size(); ++f)
      corners_here_.push_back({vertex, fans_[(f + 1) % fans_.size()].start, fans_[f].end});
    std::sort(corners_here_.begin(), corners_here_.end(),
              [](const Corner& a, const Corner& b) { return a.previous < b.previous; });
    found.insert(found.end(), corners_here_.begin(), corners_here_.end());
  }

 private:
  /// The edge of a triangle across from the vertex.
  struct Spoke {
    std::uint32_t next, previous;
  };
  /// Triangles counter-clockwise from the edge to `start` to the edge to `end`.
  struct Fan {
    std::uint32_t start, end;
    float angle;
  };

  void collect_spokes(std::uint32_t vertex) {
    spokes_.clear();
    for (std::uint32_t i = corners_.first[vertex]; i < corners_.first[vertex + 1]; ++i) {
      const std::uint32_t c = corners_.corner[i];
      const std::uint32_t* t = mesh_.triangles.data() + c / 3 * 3;
      spokes_.push_back({t[(c + 1) % 3], t[(c + 2) % 3]});
    }
  }

  /// The far end of the spoke whose triangle comes after the edge to `v`'s; kNone where none does.
  std::uint32_t leaving_from(std::uint32_t v) const {
    for (const Spoke& spoke : spokes_)
      if (spoke.previous == v) return spoke.next;
    return kNone;
  }

  std::uint32_t end_of_fan(const Spoke& first) const {
    std::uint32_t end = first.previous;
    for (std::size_t step = 0; step <= spokes_.size(); ++step) {
      const auto spoke = std::find_if(spokes_.begin(), spokes_.end(),
                                      [&](const Spoke& s) { return s.next == end; });
      if (spoke == spokes_.end()) return end;
      end = spoke->previous;
    }
    throw Error(ErrorCode::internal, "gaps: an edge of the surface has more than two triangles");
  }

  void refuse_repeated_edges() const {
    for (std::size_t i = 0; i < spokes_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (spokes_[i].next == spokes_[j].next || spokes_[i].previous == spokes_[j].previous)
          throw Error(ErrorCode::internal,
                      "gaps: triangles that share an edge do not traverse it in opposite "
                      "directions, or there are more than two");
  }

  void sort_by_angle(std::uint32_t vertex) {
    const Vec3 at = point(vertex);
    Vec3 normal;
    for (const Spoke& spoke : spokes_)
      normal = normal + cross(point(spoke.next) - at, point(spoke.previous) - at);
    normal = normalised(normal);
    const Vec3 x = point(fans_[0].start) - at, y = cross(normal, x);
    for (Fan& fan : fans_) {
      const Vec3 to = point(fan.start) - at;
      fan.angle = angle_of(dot(x, to), dot(y, to));
    }
    std::sort(fans_.begin(), fans_.end(), [](const Fan& a, const Fan& b) {
      return a.angle != b.angle ? a.angle < b.angle : a.start < b.start;
    });
  }

  Vec3 point(std::uint32_t v) const { return vertex_at(mesh_, v); }

  const TriangleMesh& mesh_;
  const VertexCorners& corners_;
  std::vector<Spoke> spokes_;
  std::vector<Fan> fans_;
  std::vector<Corner> corners_here_;
};

/// All corners, by vertex, then by previous vertex.
std::vector<Corner> find_corners(Backend& backend, const TriangleMesh& mesh) {
  const VertexCorners corners = vertex_corners(backend, mesh);
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<Corner>& found) {
    CornerFinder finder(mesh, corners);
    for (std::size_t v = begin; v < end; ++v) finder.find(static_cast<std::uint32_t>(v), found);
  };
  return collect<Corner>(backend, mesh.vertex_count(), kGrain, find);
}

/// The corner that follows each.
std::vector<std::uint32_t> link_corners(const std::vector<Corner>& corners) {
  std::vector<std::uint32_t> next(corners.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const std::array<std::uint32_t, 2> wanted = {corners[c].next, corners[c].vertex};
    const auto found = std::partition_point(corners.begin(), corners.end(), [&](const Corner& k) {
      return std::array{k.vertex, k.previous} < wanted;
    });
    if (found == corners.end() || std::array{found->vertex, found->previous} != wanted)
      throw Error(ErrorCode::internal, "gaps: the boundary of the surface does not close");
    next[c] = static_cast<std::uint32_t>(found - corners.begin());
  }
  return next;
}

}  // namespace

void GapLoops::add(std::span<const std::uint32_t> vertices) {
  if (first.empty()) first.push_back(0);
  vertex.insert(vertex.end(), vertices.begin(), vertices.end());
  first.push_back(static_cast<std::uint32_t>(vertex.size()));
}

GapLoops find_gap_loops(Backend& backend, const TriangleMesh& mesh) {
  const std::vector<Corner> corners = find_corners(backend, mesh);
  const std::vector<std::uint32_t> next = link_corners(corners);
  std::vector<std::uint8_t> visited(corners.size(), 0);
  GapLoops loops;
  loops.first.push_back(0);
  for (std::uint32_t start = 0; start < corners.size(); ++start) {
    if (visited[start]) continue;
    for (std::uint32_t c = start; !visited[c]; c = next[c]) {
      visited[c] = 1;
      loops.vertex.push_back(corners[c].vertex);
    }
    loops.first.push_back(static_cast<std::uint32_t>(loops.vertex.size()));
  }
  return loops;
}

float turning(std::span<const Vec3> points, std::span<const Vec3> normals) {
  const std::size_t n = points.size();
  float sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 in = points[i] - points[(i + n - 1) % n], out = points[(i + 1) % n] - points[i];
    const Vec3& normal = normals[i];
    const float along = dot(in, out) - dot(in, normal) * dot(out, normal);
    sum += angle_of(along, dot(normal, cross(in, out)));
  }
  return sum;
}

}  // namespace vasamesh

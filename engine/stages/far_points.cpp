#include "stages/far_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "backend/ranges.h"
#include "stages/distance.h"
#include "stages/near_triangles.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 1024;  // triangles or vertices a task takes
constexpr float kFinest = 0.2f;       // edge length that is not halved any more
constexpr float kEnough = 0.5f;       // of the limit: distances below need not be told apart

/// Triangles that follow one another round a few vertices: of a polygon of marching cubes, as a
/// rule.
class Run {
 public:
  using Corners = std::array<std::uint8_t, 3>;  // of its points

  void clear() {
    size_ = 0;
    triangles_.clear();
  }

  /// \return whether the triangle belongs to it; if so, it is taken up.
  bool take(const TriangleMesh& mesh, std::size_t triangle) {
    std::size_t size = size_;
    bool has_first = size == 0;
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = mesh.triangles[3 * triangle + i];
      const std::size_t k = static_cast<std::size_t>(
          std::find(vertices_.begin(), vertices_.begin() + static_cast<std::ptrdiff_t>(size), v) -
          vertices_.begin());
      if (k == vertices_.size()) return false;
      if (k == size) {
        vertices_[size] = v;
        points_[size++] = vertex_at(mesh, v);
      }
      corners[i] = static_cast<std::uint8_t>(k);
      has_first = has_first || k == 0;
    }
    if (size_ > 0 && size > size_ && (size > size_ + 1 || !has_first)) return false;
    size_ = size;
    triangles_.push_back(corners);
    return true;
  }

  std::span<const Vec3> points() const { return std::span(points_).first(size_); }
  const std::vector<Corners>& triangles() const { return triangles_; }

  static constexpr std::size_t kMostPoints = 8;

 private:
  std::array<std::uint32_t, kMostPoints> vertices_{};
  std::array<Vec3, kMostPoints> points_;
  std::size_t size_ = 0;
  std::vector<Corners> triangles_;
};

/// Finds the points of runs that may be too far from a surface.
class Search {
 public:
  Search(const TriangleMesh& to, const TriangleTree& tree, float limit)
      : triangles_(to, tree, limit) {}

  void add_points_of(const Run& run, std::vector<Vec3>& found) {
    const std::span<const Vec3> points = run.points();
    if (is_near_as_a_ball(points)) return;
    triangles_.take_up(points);
    std::array<NearTriangles::Set, Run::kMostPoints> near;
    NearTriangles::Set all = ~NearTriangles::Set{0};
    for (std::size_t i = 0; i < points.size(); ++i) all &= near[i] = near_to(points[i], found);
    if (all) return;  // the distance from a convex set is largest at one of the points
    for (const auto& [a, b, c] : run.triangles())
      add_points_of({{points[a], points[b], points[c]}, {near[a], near[b], near[c]}}, found);
  }

 private:
  struct Piece {
    std::array<Vec3, 3> corner;
    std::array<NearTriangles::Set, 3> near;  // to the corners
  };

  /// Whether a ball round the points is near one triangle: less work than to look at each point.
  bool is_near_as_a_ball(std::span<const Vec3> points) {
    Vec3 sum;
    for (const Vec3& p : points) sum = sum + p;
    const Vec3 middle = (1 / static_cast<float>(points.size())) * sum;
    float squared = 0;
    for (const Vec3& p : points) squared = std::max(squared, squared_norm(p - middle));
    return triangles_.hold_ball(middle, std::sqrt(squared));
  }

  NearTriangles::Set near_to(const Vec3& p, std::vector<Vec3>& found) const {
    const NearTriangles::Set near = triangles_.within(p);
    if (!near) found.push_back(p);
    return near;
  }

  void add_points_of(const Piece& whole, std::vector<Vec3>& found) const;

  static bool is_done(const Piece& piece) {
    const auto& corner = piece.corner;
    return (piece.near[0] & piece.near[1] & piece.near[2]) != 0 ||
           std::max({squared_norm(corner[1] - corner[0]), squared_norm(corner[2] - corner[1]),
                     squared_norm(corner[0] - corner[2])}) < kFinest * kFinest;
  }

  NearTriangles triangles_;
};

/// Quarters a triangle until each piece is near one triangle of the surface.
void Search::add_points_of(const Piece& whole, std::vector<Vec3>& found) const {
  std::array<Piece, 3 * 16> stack;  // 3 a level stay; the edges halve from level to level
  std::size_t size = 0;
  stack[size++] = whole;
  while (size > 0) {
    const auto [corner, near] = stack[--size];
    if (size + 4 > stack.size() || is_done({corner, near})) continue;
    Piece middle;
    for (std::size_t i = 0; i < 3; ++i) {
      middle.corner[i] = 0.5f * (corner[(i + 1) % 3] + corner[(i + 2) % 3]);
      middle.near[i] = near_to(middle.corner[i], found);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      stack[size++] = {{corner[i], middle.corner[k], middle.corner[j]},
                       {near[i], middle.near[k], middle.near[j]}};
    }
    stack[size++] = middle;
  }
}

/// A byte a vertex: whether it is near the places, if there are any.
std::vector<std::uint8_t> vertices_near(Backend& backend, const Places& places,
                                        const TriangleMesh& mesh) {
  std::vector<std::uint8_t> near(mesh.vertex_count(), 1);
  if (places.empty()) return near;
  for_each_index(backend, near.size(), kGrain, [&](std::size_t v) {
    near[v] = places.hold(vertex_at(mesh, v), Places::kMargin);
  });
  return near;
}

bool is_near(const TriangleMesh& mesh, std::size_t t, const std::vector<std::uint8_t>& near) {
  const std::uint32_t* v = &mesh.triangles[3 * t];
  return near[v[0]] && near[v[1]] && near[v[2]];
}

/// Appends the points of the triangles begin .. end - 1 near the places that may be too far.
void find_doubtful(const TriangleMesh& from, std::size_t begin, std::size_t end,
                   const std::vector<std::uint8_t>& near, Search& search,
                   std::vector<Vec3>& found) {
  Run run;
  for (std::size_t t = begin; t < end; ++t) {
    if (!is_near(from, t, near) || run.take(from, t)) continue;
    search.add_points_of(run, found);
    run.clear();
    run.take(from, t);
  }
  if (!run.triangles().empty()) search.add_points_of(run, found);
}

/// Appends the vertices near the places of which no triangle is.
void add_lone_vertices(const TriangleMesh& mesh, const std::vector<std::uint8_t>& near,
                       std::vector<Vec3>& found) {
  std::vector<std::uint8_t> lone = near;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    if (is_near(mesh, t, near))
      for (std::size_t i = 0; i < 3; ++i) lone[mesh.triangles[3 * t + i]] = 0;
  for (std::size_t v = 0; v < lone.size(); ++v)
    if (lone[v]) found.push_back(vertex_at(mesh, v));
}

void sort_unique(std::vector<Vec3>& points) {
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

}  // namespace

std::vector<Vec3> points_beyond(Backend& backend, float limit, const TriangleMesh& from,
                                const TriangleMesh& to, const TriangleTree& tree,
                                const Places& places) {
  const std::vector<std::uint8_t> near = vertices_near(backend, places, from);
  const auto find = [&](std::size_t begin, std::size_t end, std::vector<Vec3>& found) {
    Search search(to, tree, limit);
    find_doubtful(from, begin, end, near, search, found);
  };
  std::vector<Vec3> doubtful = collect<Vec3>(backend, from.triangle_count(), kGrain, find);
  add_lone_vertices(from, near, doubtful);
  sort_unique(doubtful);
  const std::vector<float> distances =
      nearest_triangles(backend, doubtful, to, tree, kEnough * limit).distances;
  std::vector<Vec3> found;
  for (std::size_t i = 0; i < doubtful.size(); ++i)
    if (distances[i] > limit) found.push_back(doubtful[i]);
  return found;
}

}  // namespace vasamesh

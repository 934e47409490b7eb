#include "stages/distance.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "backend/ranges.h"
#include "stages/triangle_tree.h"
#include "types/mesh_vertex.h"
#include "types/segment.h"
#include "types/vec3d.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 1024;  // triangles or points that a task samples
constexpr double kMostCuts = 4096;    // of a triangle's edge

struct Triangle {
  Vec3d a, b, c;
};

Vec3d vertex(const TriangleMesh& mesh, std::size_t v) { return widened(vertex_at(mesh, v)); }

Triangle triangle(const TriangleMesh& mesh, std::size_t t) {
  const std::uint32_t* v = mesh.triangles.data() + 3 * t;
  return {vertex(mesh, v[0]), vertex(mesh, v[1]), vertex(mesh, v[2])};
}

/// Inside the prism over the triangle the distance to its plane, elsewhere that to its border.
double squared_distance(const Vec3d& p, const Triangle& t) {
  const Vec3d ab = t.b - t.a, bc = t.c - t.b, ca = t.a - t.c;
  const Vec3d n = cross(ab, bc);
  const Vec3d ap = p - t.a;
  const double area = dot(n, n);
  if (area > 0 && dot(cross(n, ab), ap) >= 0 && dot(cross(n, bc), p - t.b) >= 0 &&
      dot(cross(n, ca), p - t.c) >= 0) {
    const double height = dot(n, ap);
    return height * height / area;
  }
  return std::min({squared_to_segment(p, t.a, t.b), squared_to_segment(p, t.b, t.c),
                   squared_to_segment(p, t.c, t.a)});
}

/// Squared distances from a point to the eight boxes of a node, a little too small if anything.
void squared_to_boxes(const BoxNode& node, const float (&p)[3], float (&squared)[8]) {
  constexpr float kSlack = 0.99999f;
  for (int i = 0; i < 8; ++i) {
    float sum = 0;
    for (int a = 0; a < 3; ++a) {
      const float below = node.low[a][i] - p[a], above = p[a] - node.high[a][i];
      const float out = std::max(std::max(below, above), 0.0f);
      sum += out * out;
    }
    squared[i] = sum * kSlack;
  }
}

/// The nearest point of one surface, for points that come one after another.
class Nearest {
 public:
  Nearest(const TriangleMesh& mesh, const TriangleTree& tree) : mesh_(mesh), tree_(tree) {}

  /// The distance, exact but for rounding where it is more than `enough`, else a bound from above
  /// that is at most that. Starts from the triangle found last.
  double distance(const float (&p)[3], double enough = 0) {
    enough_ = enough * enough;
    best_ = squared_distance({p[0], p[1], p[2]}, triangle(mesh_, tree_.order[last_]));
    if (best_ > enough_) descend(static_cast<int>(tree_.levels.size()) - 1, 0, p);
    return std::sqrt(best_);
  }

  /// The triangle found last.
  std::uint32_t found() const { return tree_.order[last_]; }

 private:
  void descend(int level, std::size_t node, const float (&p)[3]) {
    float squared[8];
    squared_to_boxes(tree_.levels[level][node], p, squared);
    unsigned open = 0xff;
    while (open) {
      int nearest = std::countr_zero(open);
      for (unsigned rest = open & (open - 1); rest; rest &= rest - 1)
        if (squared[std::countr_zero(rest)] < squared[nearest]) nearest = std::countr_zero(rest);
      if (!(squared[nearest] < best_)) return;
      open &= ~(1u << nearest);
      const std::size_t child = 8 * node + nearest;
      if (level > 0) {
        descend(level - 1, child, p);
      } else if (const double d =
                     squared_distance({p[0], p[1], p[2]}, triangle(mesh_, tree_.order[child]));
                 d < best_) {
        best_ = d;
        last_ = child;
      }
      if (best_ <= enough_) return;
    }
  }

  const TriangleMesh& mesh_;
  const TriangleTree& tree_;
  double best_ = 0, enough_ = 0;  // squared
  std::size_t last_ = 0;
};

struct Sums {
  double area = 0, distance = 0, square = 0, maximum = 0;

  void add(double weight, double d) {
    area += weight;
    distance += weight * d;
    square += weight * d * d;
    maximum = std::max(maximum, d);
  }
  Sums operator+(const Sums& other) const {
    return {area + other.area, distance + other.distance, square + other.square,
            std::max(maximum, other.maximum)};
  }
};

double distance_of(Nearest& nearest, const Vec3d& p) {
  return nearest.distance(
      {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
}

/// A sample at the centroid of each of n^2 equal parts.
void sample_triangle(const Triangle& t, double step, Nearest& nearest, Sums& sums) {
  const Vec3d ab = t.b - t.a, ac = t.c - t.a, bc = t.c - t.b, n = cross(ab, ac);
  const double longest = std::sqrt(std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)}));
  const int cuts = static_cast<int>(std::clamp(std::ceil(longest / step), 1.0, kMostCuts));
  const double weight = 0.5 * std::sqrt(dot(n, n)) / (static_cast<double>(cuts) * cuts);
  for (int i = 0; i < cuts; ++i)
    for (int j = 0; i + j < cuts; ++j) {
      const auto at = [&](double offset) {
        return t.a + ((i + offset) / cuts) * ab + ((j + offset) / cuts) * ac;
      };
      sums.add(weight, distance_of(nearest, at(1.0 / 3)));
      if (i + j + 1 < cuts) sums.add(weight, distance_of(nearest, at(2.0 / 3)));
    }
}

/// For each vertex the place in `order` of its first triangle.
std::vector<std::uint32_t> first_places(const TriangleMesh& mesh, const TriangleTree& tree) {
  std::vector<std::uint32_t> first(mesh.vertex_count(), 0xffffffffu);
  for (std::size_t i = tree.order.size(); i-- > 0;)
    for (int k = 0; k < 3; ++k)
      first[mesh.triangles[3 * std::size_t{tree.order[i]} + k]] = static_cast<std::uint32_t>(i);
  return first;
}

OneWayDistance one_way(Backend& backend, const TriangleMesh& from, const TriangleTree& from_tree,
                       const TriangleMesh& to, const TriangleTree& to_tree, double step) {
  const std::vector<std::uint32_t> first = first_places(from, from_tree);
  const auto sample = [&](std::size_t begin, std::size_t end) {
    Nearest nearest(to, to_tree);
    Sums sums;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t t = from_tree.order[i];
      sample_triangle(triangle(from, t), step, nearest, sums);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t v = from.triangles[3 * t + k];
        if (first[v] == i) sums.add(0, distance_of(nearest, vertex(from, v)));
      }
    }
    return sums;
  };
  const Sums total = reduce_ranges(backend, from_tree.order.size(), kGrain, Sums{}, sample);
  if (total.area <= 0) return {0, 0, total.maximum};
  return {total.distance / total.area, std::sqrt(total.square / total.area), total.maximum};
}

void require_usable(const TriangleMesh& mesh, const char* name) {
  const std::string remedy = ": give a closed triangle surface";
  if (mesh.triangles.empty())
    throw Error(ErrorCode::bad_input, std::string(name) + " has no triangles" + remedy);
  for (float x : mesh.vertices)
    if (!std::isfinite(x))
      throw Error(ErrorCode::bad_input,
                  std::string(name) + " has a vertex that is not finite" + remedy);
}

}  // namespace

DistanceReport measure_distance(Backend& backend, const TriangleMesh& surface,
                                const TriangleMesh& reference, double voxel, double step) {
  require_usable(surface, "the surface");
  require_usable(reference, "the reference surface");
  if (!(step * voxel > 0))
    throw Error(ErrorCode::bad_input,
                "the reference surface has no area: give a closed triangle surface");
  const TriangleTree surface_tree = build_triangle_tree(backend, surface);
  const TriangleTree reference_tree = build_triangle_tree(backend, reference);
  DistanceReport report;
  report.voxel = voxel;
  report.to = one_way(backend, surface, surface_tree, reference, reference_tree, step * voxel);
  report.back = one_way(backend, reference, reference_tree, surface, surface_tree, step * voxel);
  return report;
}

NearestTriangles nearest_triangles(Backend& backend, std::span<const Vec3> points,
                                   const TriangleMesh& surface, const TriangleTree& tree,
                                   float enough) {
  NearestTriangles found{std::vector<float>(points.size()),
                         std::vector<std::uint32_t>(points.size())};
  for_each_range(backend, points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Nearest nearest(surface, tree);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3& p = points[i];
      found.distances[i] = static_cast<float>(nearest.distance({p.x, p.y, p.z}, double{enough}));
      found.triangles[i] = nearest.found();
    }
  });
  return found;
}

std::vector<float> distances_to(Backend& backend, std::span<const Vec3> points,
                                const TriangleMesh& surface, const TriangleTree& tree) {
  return nearest_triangles(backend, points, surface, tree, 0).distances;
}

}  // namespace vasamesh

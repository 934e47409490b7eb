#include "stages/distance.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "stages/triangle_tree.h"
#include "types/mesh_vertex.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kTriangles = 1024;  // or points: that a task samples
constexpr double kMostCuts = 4096;        // of a triangle's edge

std::size_t parts_of(std::size_t count) { return (count + kTriangles - 1) / kTriangles; }
std::size_t part_end(std::size_t part, std::size_t count) {
  return std::min((part + 1) * kTriangles, count);
}

struct Point {
  double x, y, z;
};
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Point operator*(double s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Triangle {
  Point a, b, c;
};

Point vertex(const TriangleMesh& mesh, std::size_t v) {
  const float* p = mesh.vertices.data() + 3 * v;
  return {p[0], p[1], p[2]};
}

Triangle triangle(const TriangleMesh& mesh, std::size_t t) {
  const std::uint32_t* v = mesh.triangles.data() + 3 * t;
  return {vertex(mesh, v[0]), vertex(mesh, v[1]), vertex(mesh, v[2])};
}

double squared_to_segment(const Point& p, const Point& a, const Point& b) {
  const Point ab = b - a, ap = p - a;
  const double length = dot(ab, ab);
  const double s = length > 0 ? std::clamp(dot(ap, ab) / length, 0.0, 1.0) : 0;
  const Point off = ap - s * ab;
  return dot(off, off);
}

/// Inside the prism over the triangle the distance to its plane, elsewhere that to its border.
double squared_distance(const Point& p, const Triangle& t) {
  const Point ab = t.b - t.a, bc = t.c - t.b, ca = t.a - t.c;
  const Point n = cross(ab, bc);
  const Point ap = p - t.a;
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

  /// Whether all of a triangle is within `limit` of one triangle of the surface: the distance from
  /// a convex set is largest at a corner.
  bool is_within(const std::array<Vec3, 3>& corner, std::uint32_t of, double limit) const {
    const Triangle near = triangle(mesh_, of);
    return std::all_of(corner.begin(), corner.end(), [&](const Vec3& p) {
      return squared_distance({p.x, p.y, p.z}, near) <= limit * limit;
    });
  }

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
};

double distance_of(Nearest& nearest, const Point& p) {
  return nearest.distance(
      {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
}

/// A sample at the centroid of each of n^2 equal parts.
void sample_triangle(const Triangle& t, double step, Nearest& nearest, Sums& sums) {
  const Point ab = t.b - t.a, ac = t.c - t.a, bc = t.c - t.b, n = cross(ab, ac);
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
  const std::size_t count = from_tree.order.size();
  std::vector<Sums> parts(parts_of(count));
  backend.run(parts.size(), [&](std::size_t part) {
    Nearest nearest(to, to_tree);
    for (std::size_t i = part * kTriangles; i < part_end(part, count); ++i) {
      const std::size_t t = from_tree.order[i];
      sample_triangle(triangle(from, t), step, nearest, parts[part]);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t v = from.triangles[3 * t + k];
        if (first[v] == i) parts[part].add(0, distance_of(nearest, vertex(from, v)));
      }
    }
  });
  Sums total;
  for (const Sums& part : parts) {
    total.area += part.area;
    total.distance += part.distance;
    total.square += part.square;
    total.maximum = std::max(total.maximum, part.maximum);
  }
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
  backend.run(parts_of(points.size()), [&](std::size_t part) {
    Nearest nearest(surface, tree);
    for (std::size_t i = part * kTriangles; i < part_end(part, points.size()); ++i) {
      const Vec3& p = points[i];
      found.distances[i] = static_cast<float>(nearest.distance({p.x, p.y, p.z}, double{enough}));
      found.triangles[i] = nearest.found();
    }
  });
  return found;
}

namespace {

constexpr float kUnknown = -1;   // distance
constexpr float kFinest = 0.2f;  // edge length that is not halved any more

/// A triangle with its corners' distances, or bounds of them from above, and the triangles of the
/// other surface that are so near.
struct Sampled {
  std::array<Vec3, 3> corner;
  std::array<float, 3> distance;
  std::array<std::uint32_t, 3> found;
};

/// Squared distance from a triangle's corners within which all of it lies, from its squared edges:
/// the radius of the smallest circle round it.
float squared_reach(float a, float b, float c) {
  const float longest = std::max({a, b, c}), others = ((a + b) + c) - longest;
  if (others <= longest) return 0.25f * longest;
  const float squared_area = 4 * (a * b) - (a + b - c) * (a + b - c);  // 16 times
  return squared_area > 0 ? std::min(a * b * c / squared_area, longest / 3) : 0.25f * longest;
}

/// Adds the points of a triangle, but its corners, that are farther than `limit`: it is quartered
/// until no point of it can be, since none is farther than a corner and the way from it, or since
/// one triangle of the other surface is near enough to all of it.
void add_points_beyond(const Sampled& whole, float limit, float enough, Nearest& nearest,
                       std::vector<Vec3>& found) {
  std::array<Sampled, 3 * 16> stack;  // 3 a level stay; the edges halve from level to level
  std::size_t size = 0;
  stack[size++] = whole;
  while (size > 0) {
    const auto [corner, distance, near] = stack[--size];
    const float a = squared_norm(corner[1] - corner[0]), b = squared_norm(corner[2] - corner[1]),
                c = squared_norm(corner[0] - corner[2]);
    const float farthest = std::max({distance[0], distance[1], distance[2]});
    if (farthest + std::sqrt(squared_reach(a, b, c)) <= limit ||
        std::max({a, b, c}) < kFinest * kFinest || size + 4 > stack.size() ||
        std::any_of(near.begin(), near.end(),
                    [&](std::uint32_t t) { return nearest.is_within(corner, t, double{limit}); }))
      continue;
    Sampled middle;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p = 0.5f * (corner[(i + 1) % 3] + corner[(i + 2) % 3]);
      const auto d = static_cast<float>(nearest.distance({p.x, p.y, p.z}, double{enough}));
      if (d > limit) found.push_back(p);
      middle.corner[i] = p;
      middle.distance[i] = d;
      middle.found[i] = nearest.found();
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      stack[size++] = {{corner[i], middle.corner[k], middle.corner[j]},
                       {distance[i], middle.distance[k], middle.distance[j]},
                       {near[i], middle.found[k], middle.found[j]}};
    }
    stack[size++] = middle;
  }
}

}  // namespace

std::vector<Vec3> points_beyond(Backend& backend, float limit, const TriangleMesh& from,
                                const TriangleMesh& to, const TriangleTree& tree,
                                const Places& places) {
  // Bounds that let most triangles go without a look inside.
  const float enough_at_vertex = 0.3f * limit, enough_inside = 0.5f * limit;
  std::vector<float> distances(from.vertex_count(), kUnknown);
  std::vector<std::uint32_t> near(from.vertex_count());
  backend.run(parts_of(distances.size()), [&](std::size_t part) {
    Nearest nearest(to, tree);
    for (std::size_t v = part * kTriangles; v < part_end(part, distances.size()); ++v) {
      const Vec3 p = vertex_at(from, v);
      if (!places.empty() && !places.hold(p, Places::kMargin)) continue;
      distances[v] =
          static_cast<float>(nearest.distance({p.x, p.y, p.z}, double{enough_at_vertex}));
      near[v] = nearest.found();
    }
  });
  std::vector<std::vector<Vec3>> parts(parts_of(from.triangle_count()));
  backend.run(parts.size(), [&](std::size_t part) {
    Nearest nearest(to, tree);
    for (std::size_t t = part * kTriangles; t < part_end(part, from.triangle_count()); ++t) {
      const std::uint32_t* v = from.triangles.data() + 3 * t;
      const Sampled triangle = {
          {vertex_at(from, v[0]), vertex_at(from, v[1]), vertex_at(from, v[2])},
          {distances[v[0]], distances[v[1]], distances[v[2]]},
          {near[v[0]], near[v[1]], near[v[2]]}};
      if (std::min({triangle.distance[0], triangle.distance[1], triangle.distance[2]}) != kUnknown)
        add_points_beyond(triangle, limit, enough_inside, nearest, parts[part]);
    }
  });
  std::vector<Vec3> found;
  for (std::size_t v = 0; v < distances.size(); ++v)
    if (distances[v] > limit) found.push_back(vertex_at(from, v));
  for (const std::vector<Vec3>& part : parts) found.insert(found.end(), part.begin(), part.end());
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  std::sort(found.begin(), found.end(), before);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<float> distances_to(Backend& backend, std::span<const Vec3> points,
                                const TriangleMesh& surface, const TriangleTree& tree) {
  return nearest_triangles(backend, points, surface, tree, 0).distances;
}

}  // namespace vasamesh

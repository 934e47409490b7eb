#include "stages/quality.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/adjacency.h"
#include "types/mesh_vertex.h"
#include "types/vec3d.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 8192;  // triangles or vertices a task takes
constexpr double kCloseRatio = 1.5;   // of two edges' lengths
constexpr float kSharp = 60;          // degrees: dihedral angles below it

Vec3d vertex(const TriangleMesh& mesh, std::uint32_t v) { return widened(vertex_at(mesh, v)); }

/// Normal to the triangle, as long as twice its area.
Vec3d area_vector(const TriangleMesh& mesh, std::uint32_t triangle) {
  const std::uint32_t* t = mesh.triangles.data() + 3 * std::size_t{triangle};
  const Vec3d a = vertex(mesh, t[0]);
  return cross(vertex(mesh, t[1]) - a, vertex(mesh, t[2]) - a);
}

/// Degrees.
double angle_between(const Vec3d& a, const Vec3d& b) {
  const Vec3d product = cross(a, b);
  return std::atan2(std::sqrt(dot(product, product)), dot(a, b)) * 180 / std::numbers::pi;
}

struct Figures {
  double shortest, longest, mean_edge, least_angle, area, volume;
  int close_pairs;
};

/// How many of the three pairs of edges have nearly the same length.
int close_pairs(const double (&edge)[3]) {
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    const auto [shorter, longer] = std::minmax(edge[i], edge[(i + 1) % 3]);
    count += shorter > 0 && longer <= kCloseRatio * shorter;
  }
  return count;
}

Figures figures_of(const TriangleMesh& mesh, std::size_t triangle, const Vec3d& origin) {
  const std::uint32_t* t = mesh.triangles.data() + 3 * triangle;
  const Vec3d p[3] = {vertex(mesh, t[0]), vertex(mesh, t[1]), vertex(mesh, t[2])};
  double edge[3];  // edge i lies across from corner i
  for (int i = 0; i < 3; ++i) {
    const Vec3d e = p[(i + 2) % 3] - p[(i + 1) % 3];
    edge[i] = std::sqrt(dot(e, e));
  }
  const int least = static_cast<int>(std::min_element(edge, edge + 3) - edge);
  const Vec3d a = p[(least + 1) % 3] - p[least], b = p[(least + 2) % 3] - p[least];
  const Vec3d normal = cross(a, b);
  return {edge[least],
          std::max({edge[0], edge[1], edge[2]}),
          (edge[0] + edge[1] + edge[2]) / 3,
          angle_between(a, b),
          0.5 * std::sqrt(dot(normal, normal)),
          dot(p[least] - origin, normal) / 6,
          close_pairs(edge)};
}

/// Of some triangles.
struct ShapeSums {
  double area = 0, volume = 0;
  std::int64_t close_pairs = 0;

  ShapeSums operator+(const ShapeSums& other) const {
    return {area + other.area, volume + other.volume, close_pairs + other.close_pairs};
  }
};

double fraction(std::size_t count, std::size_t of) {
  return of == 0 ? 0 : static_cast<double>(count) / static_cast<double>(of);
}

/// Of the edges that two triangles share.
struct EdgeFigures {
  std::vector<float> length;      ///< mm
  std::vector<float> size_ratio;  ///< longer / shorter mean edge of the two
  std::vector<float> dihedral;    ///< the angle between them, degrees
};

EdgeFigures edge_figures(Backend& backend, const TriangleMesh& mesh,
                         const std::vector<float>& mean_edge) {
  const VertexCorners corners = vertex_corners(backend, mesh);
  const auto measure = [&](std::size_t begin, std::size_t end) {
    EdgeFigures figures;
    for (std::size_t v = begin; v < end; ++v)
      for_each_shared_edge_up(
          mesh, corners, static_cast<std::uint32_t>(v), [&](std::uint32_t c, std::uint32_t d) {
            const std::uint32_t w = mesh.triangles[c / 3 * 3 + (c + 1) % 3];
            const Vec3d along = vertex(mesh, w) - vertex(mesh, static_cast<std::uint32_t>(v));
            figures.length.push_back(static_cast<float>(std::sqrt(dot(along, along))));
            const float a = mean_edge[c / 3], b = mean_edge[d / 3];
            figures.size_ratio.push_back(a == b ? 1 : std::max(a, b) / std::min(a, b));
            figures.dihedral.push_back(static_cast<float>(
                180 - angle_between(area_vector(mesh, c / 3), area_vector(mesh, d / 3))));
          });
    return figures;
  };
  EdgeFigures all;
  for (const EdgeFigures& part : map_ranges(backend, mesh.vertex_count(), kGrain, measure)) {
    append_in_steps<float>(backend, part.length, all.length);
    append_in_steps<float>(backend, part.size_ratio, all.size_ratio);
    append_in_steps<float>(backend, part.dihedral, all.dihedral);
  }
  return all;
}

/// Numbers in the order of the floats that they stand for.
std::uint32_t key_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0f);  // one zero
  return bits >> 31 ? ~bits : bits | 0x80000000u;
}
float value_of(std::uint32_t key) {
  return std::bit_cast<float>(key >> 31 ? key & 0x7fffffffu : ~key);
}

using Ranks = std::array<std::size_t, 3>;

/// The bin that holds a rank, which becomes that within the bin.
std::uint32_t bin_of(const std::vector<std::uint32_t>& counts, std::size_t& rank) {
  std::uint32_t bin = 0;
  for (; rank >= counts[bin]; ++bin) rank -= counts[bin];
  return bin;
}

/// What stands at those ranks, from 0, among the values in order: the upper halves of the keys are
/// counted, then the lower ones of those whose upper one is right.
std::array<float, 3> values_at(const Backend& backend, std::span<const float> values, Ranks ranks) {
  constexpr std::size_t kBins = 1 << 16;
  std::vector<std::uint32_t> upper(kBins, 0);
  in_steps(backend, values.size(), [&](std::size_t i) { ++upper[key_of(values[i]) >> 16]; });
  std::array<std::uint32_t, 3> bin{};
  for (std::size_t r = 0; r < 3; ++r) bin[r] = bin_of(upper, ranks[r]);
  std::array<std::vector<std::uint32_t>, 3> lower;
  lower.fill(std::vector<std::uint32_t>(kBins, 0));
  in_steps(backend, values.size(), [&](std::size_t i) {
    const std::uint32_t key = key_of(values[i]);
    for (std::size_t r = 0; r < 3; ++r)
      if (key >> 16 == bin[r]) ++lower[r][key & (kBins - 1)];
  });
  std::array<float, 3> found{};
  for (std::size_t r = 0; r < 3; ++r)
    found[r] = value_of(bin[r] << 16 | bin_of(lower[r], ranks[r]));
  return found;
}

}  // namespace

Distribution describe(const Backend& backend, std::span<const float> values) {
  if (values.empty()) return {};
  const auto count = static_cast<double>(values.size());
  Distribution result;
  double sum = 0, squares = 0;
  float minimum = values[0], maximum = values[0];
  in_steps(backend, values.size(), [&](std::size_t i) {
    sum += values[i];
    minimum = std::min(minimum, values[i]);
    maximum = std::max(maximum, values[i]);
  });
  const double mean = sum / count;
  in_steps(backend, values.size(),
           [&](std::size_t i) { squares += (values[i] - mean) * (values[i] - mean); });
  const auto rank = [&](double share) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(share * count))) - 1;
  };
  const auto [low, middle, high] = values_at(backend, values, {rank(0.05), rank(0.5), rank(0.95)});
  return {mean, std::sqrt(squares / count), minimum, low, middle, high, maximum};
}

Distribution describe_weighted(const std::vector<float>& values,
                               const std::vector<float>& weights) {
  std::vector<std::uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::erase_if(order, [&](std::uint32_t i) { return !(weights[i] > 0); });
  if (order.empty()) return {};
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return values[a] < values[b] || (values[a] == values[b] && a < b);
  });
  double total = 0, sum = 0, squares = 0;
  for (std::uint32_t i : order) total += weights[i], sum += double{weights[i]} * values[i];
  const double mean = sum / total;
  for (std::uint32_t i : order) squares += weights[i] * (values[i] - mean) * (values[i] - mean);
  const auto percentile = [&](double share) {
    double below = 0;
    for (std::uint32_t i : order)
      if ((below += weights[i]) >= share * total) return double{values[i]};
    return double{values[order.back()]};
  };
  return {mean,
          std::sqrt(squares / total),
          values[order.front()],
          percentile(0.05),
          percentile(0.5),
          percentile(0.95),
          values[order.back()]};
}

TriangleShapes triangle_shapes(Backend& backend, const TriangleMesh& mesh) {
  const std::size_t count = mesh.triangle_count();
  TriangleShapes shapes{filled_in_steps<float>(backend, count),
                        filled_in_steps<float>(backend, count),
                        filled_in_steps<float>(backend, count)};
  if (count == 0) return shapes;
  const Vec3d origin = vertex(mesh, mesh.triangles[0]);
  const auto measure = [&](std::size_t begin, std::size_t end) {
    ShapeSums sums;
    for (std::size_t t = begin; t < end; ++t) {
      const Figures f = figures_of(mesh, t, origin);
      shapes.edge_ratio[t] = f.longest > 0 ? static_cast<float>(f.shortest / f.longest) : 0.0f;
      shapes.least_angle[t] = static_cast<float>(f.least_angle);
      shapes.mean_edge[t] = static_cast<float>(f.mean_edge);
      sums = sums + ShapeSums{f.area, f.volume, f.close_pairs};
    }
    return sums;
  };
  const ShapeSums sums = reduce_ranges(backend, count, kGrain, ShapeSums{}, measure);
  shapes.area = sums.area;
  shapes.volume = sums.volume;
  shapes.close_pairs = sums.close_pairs;
  return shapes;
}

QualityReport measure_quality(Backend& backend, const TriangleMesh& mesh) {
  const std::size_t count = mesh.triangle_count();
  QualityReport report;
  if (count == 0) return report;
  const TriangleShapes shapes = triangle_shapes(backend, mesh);
  report.area = shapes.area;
  report.volume = shapes.volume;
  report.edges_within_15 = fraction(static_cast<std::size_t>(shapes.close_pairs), 3 * count);
  std::size_t above_08 = 0, below_03 = 0, below_01 = 0;
  in_steps(backend, count, [&](std::size_t t) {
    const float tau = shapes.edge_ratio[t];
    above_08 += tau >= 0.8f;
    below_03 += tau < 0.3f;
    below_01 += tau < 0.1f;
  });
  report.edge_ratio_above_08 = fraction(above_08, count);
  report.edge_ratio_below_03 = fraction(below_03, count);
  report.edge_ratio_below_01 = fraction(below_01, count);
  const EdgeFigures edges = edge_figures(backend, mesh, shapes.mean_edge);
  in_steps(backend, edges.dihedral.size(),
           [&](std::size_t e) { report.sharp_edges += edges.dihedral[e] < kSharp; });
  backend.run(5, [&](std::size_t figure) {
    if (figure == 0) report.edge_ratio = describe(backend, shapes.edge_ratio);
    if (figure == 1) report.least_angle = describe(backend, shapes.least_angle);
    if (figure == 2) report.size_ratio = describe(backend, edges.size_ratio);
    if (figure == 3) report.dihedral_angle = describe(backend, edges.dihedral);
    if (figure == 4) report.edge_length = describe(backend, edges.length);
  });
  return report;
}

}  // namespace vasamesh

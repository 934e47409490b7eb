#include "stages/quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "stages/adjacency.h"
#include "types/mesh_vertex.h"
#include "types/vec3d.h"

namespace vasamesh {

namespace {

constexpr std::size_t kChunk = 8192;  // triangles or vertices a task takes
constexpr double kCloseRatio = 1.5;   // of two edges' lengths
constexpr float kSharp = 60;          // degrees: dihedral angles below it

std::size_t chunks(std::size_t count) { return (count + kChunk - 1) / kChunk; }

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

double fraction(std::size_t count, std::size_t of) {
  return of == 0 ? 0 : static_cast<double>(count) / static_cast<double>(of);
}

/// Of the edges that two triangles share.
struct EdgeFigures {
  std::vector<float> size_ratio;  ///< longer / shorter mean edge of the two
  std::vector<float> dihedral;    ///< the angle between them, degrees
};

EdgeFigures edge_figures(Backend& backend, const TriangleMesh& mesh,
                         const std::vector<float>& mean_edge) {
  const VertexCorners corners = vertex_corners(mesh);
  std::vector<EdgeFigures> parts(chunks(mesh.vertex_count()));
  backend.run(parts.size(), [&](std::size_t part) {
    const std::size_t end = std::min((part + 1) * kChunk, mesh.vertex_count());
    for (std::size_t v = part * kChunk; v < end; ++v)
      for_each_shared_edge_up(
          mesh, corners, static_cast<std::uint32_t>(v), [&](std::uint32_t c, std::uint32_t d) {
            const float a = mean_edge[c / 3], b = mean_edge[d / 3];
            parts[part].size_ratio.push_back(a == b ? 1 : std::max(a, b) / std::min(a, b));
            parts[part].dihedral.push_back(static_cast<float>(
                180 - angle_between(area_vector(mesh, c / 3), area_vector(mesh, d / 3))));
          });
  });
  EdgeFigures all;
  for (const EdgeFigures& part : parts) {
    all.size_ratio.insert(all.size_ratio.end(), part.size_ratio.begin(), part.size_ratio.end());
    all.dihedral.insert(all.dihedral.end(), part.dihedral.begin(), part.dihedral.end());
  }
  return all;
}

}  // namespace

Distribution describe(std::vector<float>& values) {
  if (values.empty()) return {};
  const auto count = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (float value : values) sum += value;
  const double mean = sum / count;
  for (float value : values) squares += (value - mean) * (value - mean);
  const auto rank = [&](double share) {
    return values.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(share * count))) -
           1;
  };
  // The outer percentiles are sought on their own side of the median alone.
  const auto low = rank(0.05), middle = rank(0.5), high = rank(0.95);
  std::nth_element(values.begin(), middle, values.end());
  Distribution result;
  result.median = *middle;
  std::nth_element(values.begin(), low, middle);
  result.percentile_5 = *low;
  std::nth_element(middle, high, values.end());
  result.percentile_95 = *high;
  result.minimum = *std::min_element(values.begin(), low + 1);
  result.maximum = *std::max_element(high, values.end());
  result.mean = mean;
  result.deviation = std::sqrt(squares / count);
  return result;
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
  TriangleShapes shapes{std::vector<float>(count), std::vector<float>(count),
                        std::vector<float>(count)};
  std::vector<double> area(chunks(count), 0), volume(chunks(count), 0);
  std::vector<std::int64_t> pairs(chunks(count), 0);
  if (count == 0) return shapes;
  const Vec3d origin = vertex(mesh, mesh.triangles[0]);
  backend.run(chunks(count), [&](std::size_t chunk) {
    for (std::size_t t = chunk * kChunk; t < std::min((chunk + 1) * kChunk, count); ++t) {
      const Figures f = figures_of(mesh, t, origin);
      shapes.edge_ratio[t] = f.longest > 0 ? static_cast<float>(f.shortest / f.longest) : 0.0f;
      shapes.least_angle[t] = static_cast<float>(f.least_angle);
      shapes.mean_edge[t] = static_cast<float>(f.mean_edge);
      area[chunk] += f.area;
      volume[chunk] += f.volume;
      pairs[chunk] += f.close_pairs;
    }
  });
  for (double part : area) shapes.area += part;
  for (double part : volume) shapes.volume += part;
  for (std::int64_t part : pairs) shapes.close_pairs += part;
  return shapes;
}

QualityReport measure_quality(Backend& backend, const TriangleMesh& mesh) {
  const std::size_t count = mesh.triangle_count();
  QualityReport report;
  if (count == 0) return report;
  TriangleShapes shapes = triangle_shapes(backend, mesh);
  report.area = shapes.area;
  report.volume = shapes.volume;
  report.edges_within_15 = fraction(static_cast<std::size_t>(shapes.close_pairs), 3 * count);
  const std::vector<float>& ratio = shapes.edge_ratio;
  const auto share = [&](auto&& condition) {
    return fraction(std::count_if(ratio.begin(), ratio.end(), condition), count);
  };
  report.edge_ratio_above_08 = share([](float tau) { return tau >= 0.8f; });
  report.edge_ratio_below_03 = share([](float tau) { return tau < 0.3f; });
  report.edge_ratio_below_01 = share([](float tau) { return tau < 0.1f; });
  EdgeFigures edges = edge_figures(backend, mesh, shapes.mean_edge);
  report.sharp_edges = std::count_if(edges.dihedral.begin(), edges.dihedral.end(),
                                     [](float angle) { return angle < kSharp; });
  backend.run(4, [&](std::size_t figure) {
    if (figure == 0) report.edge_ratio = describe(shapes.edge_ratio);
    if (figure == 1) report.least_angle = describe(shapes.least_angle);
    if (figure == 2) report.size_ratio = describe(edges.size_ratio);
    if (figure == 3) report.dihedral_angle = describe(edges.dihedral);
  });
  return report;
}

}  // namespace vasamesh

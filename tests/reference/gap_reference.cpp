#include "reference/gap_reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace vasamesh::test {

namespace {

struct Point {
  double x, y, z;
};
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const Point& a) { return std::sqrt(dot(a, a)); }
Point wide(const Vec3& a) { return {a.x, a.y, a.z}; }
double angle(const Point& a, const Point& b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

using Triangles = std::vector<std::uint16_t>;

Point normal_of(const GapPolygon& polygon, const std::uint16_t* t) {
  const Point a = wide(polygon.points[t[0]]);
  return cross(wide(polygon.points[t[1]]) - a, wide(polygon.points[t[2]]) - a);
}

bool is_near(const FieldSample& sample, double reach) {
  return sample.known && std::abs(sample.value) / length(wide(sample.gradient)) <= reach;
}

bool may_join(const GapPolygon& polygon, const GapRules& rules, std::size_t a, std::size_t b) {
  const Vec3 &p = polygon.points[a], &q = polygon.points[b];
  return polygon.chords[polygon.points.size() * a + b] != 0 &&
         is_near(sample_field(rules.field, 0.5f * (p + q)),
                 rules.reach * length(wide(q) - wide(p)));
}

bool obeys(const GapPolygon& polygon, const GapRules& rules, const std::uint16_t* t) {
  const std::size_t n = polygon.points.size();
  const Point normal = normal_of(polygon, t);
  const double steepest = std::acos(static_cast<double>(rules.least_cosine));
  double longest = 0;
  Vec3 middle;
  for (int i = 0; i < 3; ++i) {
    const std::size_t a = t[i], b = t[(i + 1) % 3], low = std::min(a, b), high = std::max(a, b);
    const bool is_edge = high - low == 1 || high - low == n - 1;
    if (!is_edge && !may_join(polygon, rules, a, b)) return false;
    if (angle(normal, wide(polygon.normals[a])) > steepest) return false;
    longest = std::max(longest, length(wide(polygon.points[b]) - wide(polygon.points[a])));
    middle = middle + (1.0f / 3) * polygon.points[a];
  }
  const FieldSample sample = sample_field(rules.field, middle);
  return is_near(sample, rules.reach * longest) &&
         angle(normal, wide(-sample.gradient)) <=
             std::acos(static_cast<double>(rules.middle_cosine));
}

/// All triangulations of the part from corner i to j.
std::vector<Triangles> all_of(const GapPolygon& polygon, const GapRules& rules, std::uint16_t i,
                              std::uint16_t j) {
  if (j - i < 2) return {{}};
  std::vector<Triangles> all;
  for (std::uint16_t k = i + 1; k < j; ++k) {
    const std::uint16_t t[3] = {i, k, j};
    if (!obeys(polygon, rules, t)) continue;
    const auto left = all_of(polygon, rules, i, k), right = all_of(polygon, rules, k, j);
    for (const Triangles& a : left)
      for (const Triangles& b : right) {
        all.push_back(a);
        all.back().insert(all.back().end(), b.begin(), b.end());
        all.back().insert(all.back().end(), t, t + 3);
      }
  }
  return all;
}

}  // namespace

GapFigures gap_figures(const GapPolygon& polygon, std::span<const std::uint16_t> triangles) {
  constexpr double kFlat = 3.14159265358979;
  GapFigures figures;
  figures.least_angle = kFlat;
  std::map<std::array<std::uint16_t, 2>, Point> normal_at;  // by directed edge
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const std::uint16_t* corner = triangles.data() + t;
    const Point normal = normal_of(polygon, corner);
    double squares = 0, steepest = 0;
    for (int i = 0; i < 3; ++i) {
      const std::uint16_t a = corner[i], b = corner[(i + 1) % 3], c = corner[(i + 2) % 3];
      const Point at = wide(polygon.points[a]);
      const Point ab = wide(polygon.points[b]) - at, ac = wide(polygon.points[c]) - at;
      figures.least_angle = std::min(figures.least_angle, angle(ab, ac));
      squares += dot(ab, ab);
      steepest = std::max(steepest, angle(normal, wide(polygon.normals[a])));
      normal_at[{a, b}] = normal;
    }
    figures.area += length(normal) / 2;
    figures.cost += squares / length(normal) * (2 - std::cos(steepest));
  }
  const auto n = static_cast<std::uint16_t>(polygon.points.size());
  for (const auto& [edge, normal] : normal_at) {
    const auto back = normal_at.find({edge[1], edge[0]});
    const bool is_rim = edge[1] == (edge[0] + 1) % n;
    const Point across = back != normal_at.end() ? back->second
                         : is_rim                ? wide(polygon.across[edge[0]])
                                                 : normal;
    if (dot(across, across) > 0)
      figures.largest_turn = std::max(figures.largest_turn, angle(normal, across));
  }
  return figures;
}

bool is_valid(const GapPolygon& polygon, const GapRules& rules,
              std::span<const std::uint16_t> triangles) {
  const auto n = static_cast<std::uint16_t>(polygon.points.size());
  if (triangles.size() != 3 * (n - 2u)) return false;
  std::map<std::array<std::uint16_t, 2>, int> uses;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    if (!obeys(polygon, rules, triangles.data() + t)) return false;
    for (int i = 0; i < 3; ++i) ++uses[{triangles[t + i], triangles[t + (i + 1) % 3]}];
  }
  for (const auto& [edge, count] : uses) {
    const bool is_rim = edge[1] == (edge[0] + 1) % n;
    if (count != 1 || uses.count({edge[1], edge[0]}) == is_rim) return false;
  }
  return true;
}

std::optional<BestGaps> best_of_all(const GapPolygon& polygon, const GapRules& rules) {
  constexpr double kSame = 1e-5;
  const auto all = all_of(polygon, rules, 0, static_cast<std::uint16_t>(polygon.points.size() - 1));
  if (all.empty()) return std::nullopt;
  std::vector<GapFigures> figures;
  for (const Triangles& triangles : all) figures.push_back(gap_figures(polygon, triangles));
  double angle = 0;
  for (const GapFigures& f : figures) angle = std::max(angle, f.least_angle);
  std::erase_if(figures, [&](const GapFigures& f) { return f.least_angle < angle - kSame; });
  BestGaps best;
  best.valid = static_cast<int>(all.size());
  best.exact =
      *std::min_element(figures.begin(), figures.end(),
                        [](const GapFigures& a, const GapFigures& b) { return a.cost < b.cost; });
  best.paper = *std::min_element(figures.begin(), figures.end(),
                                 [&](const GapFigures& a, const GapFigures& b) {
                                   if (std::abs(a.largest_turn - b.largest_turn) > kSame)
                                     return a.largest_turn < b.largest_turn;
                                   return a.area < b.area;
                                 });
  return best;
}

}  // namespace vasamesh::test

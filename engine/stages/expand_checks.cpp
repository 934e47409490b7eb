#include "stages/expand_checks.h"

#include <algorithm>
#include <cmath>

#include "stages/expand_rules.h"

namespace vasamesh {

using namespace expand_rules;

namespace {

std::array<float, 3> squared_edges(const Triangle& t) {
  return {squared_norm(t[1] - t[0]), squared_norm(t[2] - t[1]), squared_norm(t[0] - t[2])};
}

}  // namespace

float edge_ratio(const Triangle& t) {
  const auto edges = squared_edges(t);
  const auto [least, most] = std::minmax_element(edges.begin(), edges.end());
  return *most > 0 ? std::sqrt(*least / *most) : 0.0f;
}

float longest_edge(const Triangle& t) {
  const auto edges = squared_edges(t);
  return std::sqrt(*std::max_element(edges.begin(), edges.end()));
}

bool faces_outward(const Triangle& t, const std::array<Vec3, 3>& normals) {
  const Vec3 n = unit_normal(t);
  return dot(n, normals[0]) > kFacing && dot(n, normals[1]) > kFacing &&
         dot(n, normals[2]) > kFacing;
}

bool edge_on_surface(const FieldView& field, const Vec3& a, const Vec3& b, float off) {
  const FieldSample middle = sample_field(field, 0.5f * (a + b));
  if (!middle.known) return false;
  const float slope = norm(middle.gradient), length = norm(b - a);
  return std::fabs(middle.value) <= off * length * slope &&
         std::fabs(dot(middle.gradient, b - a)) <= kAlongGradient * slope * length;
}

bool edge_crosses(const BoundaryEdge& edge, const Triangle& t) {
  const Vec3 n = unit_normal(t);
  if (!(dot(n, edge.normal) > kSameSheet)) return false;
  const float longest = longest_edge(t);
  const float start_height = dot(edge.start - t[0], n), end_height = dot(edge.end - t[0], n);
  if (std::min(std::fabs(start_height), std::fabs(end_height)) > kSheetOffset * longest)
    return false;
  // The part of the edge between the three sides, as parameters from start to end.
  float from = 0, to = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 inward = normalised(cross(n, t[(i + 1) % 3] - t[i]));
    const float start = dot(edge.start - t[i], inward) - kShrink * longest;
    const float end = dot(edge.end - t[i], inward) - kShrink * longest;
    if (start < 0 && end < 0) return false;
    if (start < 0) from = std::max(from, start / (start - end));
    if (end < 0) to = std::min(to, start / (start - end));
  }
  return from < to;
}

}  // namespace vasamesh

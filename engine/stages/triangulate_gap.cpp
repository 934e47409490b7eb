#include "stages/triangulate_gap.h"

#include <algorithm>
#include <cmath>

namespace vasamesh {

namespace {

constexpr float kNever = 3e38f;  // the measure or cost of what cannot be triangulated

}  // namespace

GapPolygon gap_polygon(const GapView& gaps, std::size_t g) {
  const std::size_t first = gaps.first[g], n = gaps.first[g + 1] - first;
  GapPolygon polygon;
  polygon.points = {&gaps.points[first], n};
  polygon.normals = {&gaps.normals[first], n};
  if (gaps.across.size) polygon.across = {&gaps.across[first], n};
  polygon.chords = {&gaps.chords[gaps.chord_first[g]], n * n};
  return polygon;
}

bool GapTriangulator::run(const GapPolygon& polygon, const GapRules& rules, StitchMode mode) {
  polygon_ = polygon;
  rules_ = rules;
  n_ = polygon.points.size();
  triangles_.clear();
  if (n_ < 3 || n_ > kMostCorners) return false;
  prepare();
  if (mode == StitchMode::paper) {
    minimise_lexicographic();
  } else {
    minimise_measure();
    if (least_[n_ - 1] < kNever) minimise_cost();
  }
  measure_ = least_[n_ - 1];
  total_ = sum_[n_ - 1];
  if (!(measure_ < kNever)) return false;
  trace();
  return true;
}

void GapTriangulator::prepare() {
  const std::size_t entries = n_ * n_;
  if (squared_.size() < entries) {
    squared_.resize(entries);
    least_.resize(entries);
    sum_.resize(entries);
    via_.resize(entries);
    candidate_.resize(n_);
  }
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = i + 1; j < n_; ++j)
      squared_[n_ * i + j] = squared_[n_ * j + i] =
          squared_norm(polygon_.points[j] - polygon_.points[i]);
  for (std::size_t i = 0; i + 1 < n_; ++i) {
    const std::size_t edge = n_ * i + i + 1, back = edge + n_ - 1;
    least_[edge] = least_[back] = 0;
    sum_[edge] = sum_[back] = 0;
  }
}

bool GapTriangulator::obeys_normals(std::size_t i, std::size_t k, std::size_t j, Vec3& product,
                                    float& squared, float& worst) const {
  const auto& p = polygon_.points;
  product = cross(p[k] - p[i], p[j] - p[i]);
  squared = squared_norm(product);
  worst = std::min({dot(polygon_.normals[i], product), dot(polygon_.normals[k], product),
                    dot(polygon_.normals[j], product)});
  return squared > 0 && is_within_angle(worst, rules_.least_cosine, squared);
}

bool GapTriangulator::obeys_middle(std::size_t i, std::size_t k, std::size_t j,
                                   const Vec3& product) const {
  const auto& p = polygon_.points;
  return middle_follows_surface(rules_, p[i], p[k], p[j], product);
}

void GapTriangulator::minimise_measure() {
  for (std::size_t width = 2; width < n_; ++width) {
    for (std::size_t i = 0; i + width < n_; ++i) {
      const std::size_t j = i + width;
      float best = kNever;
      std::size_t via = 0;
      if (may_join(i, j)) {
        const float *left = &least_[n_ * i], *right = &least_[n_ * j];
        const float *from_i = &squared_[n_ * i], *from_j = &squared_[n_ * j];
        for (std::size_t k = i + 1; k < j; ++k)
          candidate_[k] = std::max(std::max(left[k], right[k]),
                                   least_angle_measure(from_i[k], from_j[k], from_i[j]));
        for (std::size_t k = i + 1; k < j; ++k) {
          if (!(candidate_[k] < best)) continue;
          Vec3 product;
          float squared, worst;
          if (!obeys_normals(i, k, j, product, squared, worst)) continue;
          if (!obeys_middle(i, k, j, product)) continue;
          best = candidate_[k];
          via = k;
        }
      }
      least_[n_ * i + j] = least_[n_ * j + i] = best;
      via_[n_ * i + j] = static_cast<std::uint16_t>(via);
    }
  }
}

void GapTriangulator::minimise_cost() {
  const float allowed = least_[n_ - 1];
  for (std::size_t width = 2; width < n_; ++width) {
    for (std::size_t i = 0; i + width < n_; ++i) {
      const std::size_t j = i + width;
      float best = kNever;
      std::size_t via = 0;
      if (least_[n_ * i + j] <= allowed) {
        const float *left = &sum_[n_ * i], *right = &sum_[n_ * j];
        const float *from_i = &squared_[n_ * i], *from_j = &squared_[n_ * j];
        for (std::size_t k = i + 1; k < j; ++k) {
          const float parts = left[k] + right[k];
          if (!(parts < best)) continue;
          const float a = from_i[k], b = from_j[k], c = from_i[j];
          if (!(least_angle_measure(a, b, c) <= allowed)) continue;
          Vec3 product;
          float squared, worst;
          if (!obeys_normals(i, k, j, product, squared, worst)) continue;
          const float twice_area = std::sqrt(squared);
          const float cost = parts + triangle_cost((a + b) + c, twice_area, worst / twice_area);
          if (!(cost < best) || !obeys_middle(i, k, j, product)) continue;
          best = cost;
          via = k;
        }
      }
      sum_[n_ * i + j] = sum_[n_ * j + i] = best;
      via_[n_ * i + j] = static_cast<std::uint16_t>(via);
    }
  }
}

float GapTriangulator::largest_turn(std::size_t i, std::size_t k, std::size_t j,
                                    const Vec3& normal) const {
  float turn =
      std::max(k - i > 1 ? turn_[n_ * i + k] : -1.0f, j - k > 1 ? turn_[n_ * k + j] : -1.0f);
  const Vec3& before = k - i > 1 ? top_[n_ * i + k] : polygon_.across[i];
  const Vec3& after = j - k > 1 ? top_[n_ * k + j] : polygon_.across[k];
  const auto meet = [&](const Vec3& neighbour) {
    if (squared_norm(neighbour) > 0) turn = std::max(turn, -dot(neighbour, normal));
  };
  meet(before);
  meet(after);
  if (j - i + 1 == n_) meet(polygon_.across[j]);
  return turn;
}

void GapTriangulator::minimise_lexicographic() {
  if (turn_.size() < n_ * n_) {
    turn_.resize(n_ * n_);
    top_.resize(n_ * n_);
  }
  for (std::size_t width = 2; width < n_; ++width) {
    for (std::size_t i = 0; i + width < n_; ++i) {
      const std::size_t j = i + width, entry = n_ * i + j;
      float least = kNever, turn = kNever, area = kNever;
      std::size_t via = 0;
      const std::size_t end = may_join(i, j) ? j : i;
      for (std::size_t k = i + 1; k < end; ++k) {
        const float measure = std::max(
            std::max(least_[n_ * i + k], least_[n_ * k + j]),
            least_angle_measure(squared_[n_ * i + k], squared_[n_ * k + j], squared_[entry]));
        if (!(measure <= least) || !(measure < kNever)) continue;
        Vec3 product;
        float squared, worst;
        if (!obeys_normals(i, k, j, product, squared, worst)) continue;
        const float twice_area = std::sqrt(squared);
        const Vec3 normal = (1.0f / twice_area) * product;
        const float turned = largest_turn(i, k, j, normal);
        const float sum = (sum_[n_ * i + k] + sum_[n_ * k + j]) + 0.5f * twice_area;
        const bool better = measure < least || turned < turn || (turned == turn && sum < area);
        if (!better || !obeys_middle(i, k, j, product)) continue;
        least = measure;
        turn = turned;
        area = sum;
        via = k;
        top_[entry] = normal;
      }
      least_[entry] = least_[n_ * j + i] = least;
      sum_[entry] = sum_[n_ * j + i] = area;
      turn_[entry] = turn;
      via_[entry] = static_cast<std::uint16_t>(via);
    }
  }
}

/// A part's first triangle is known when its own turn comes: until then its place holds its ends.
void GapTriangulator::trace() {
  triangles_.resize(3 * (n_ - 2));
  triangles_[0] = 0;
  triangles_[2] = static_cast<std::uint16_t>(n_ - 1);
  for (std::size_t t = 0; t < n_ - 2; ++t) {
    std::uint16_t* triangle = &triangles_[3 * t];
    const std::uint16_t i = triangle[0], j = triangle[2], k = via_[n_ * i + j];
    triangle[1] = k;
    const auto set_part = [](std::uint16_t* first, std::uint16_t from, std::uint16_t to) {
      if (to - from < 2) return;
      first[0] = from;
      first[2] = to;
    };
    set_part(triangle + 3, i, k);
    set_part(triangle + 3 * (k - i), k, j);
  }
}

}  // namespace vasamesh

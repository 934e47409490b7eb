#include "stages/close_gap.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace vasamesh {

namespace {

/// What is tried for a gap, in this order.
struct Attempt {
  float least_cosine, middle_cosine, reach;  // as in GapRules
  bool star;                                 // a vertex in the middle instead of chords
};
constexpr Attempt kAttempts[] = {{0.5f, 0.5f, 0.35f, false},  {0.25f, 0.25f, 0.35f, false},
                                 {0.25f, 0.25f, 0.35f, true}, {0.0f, 0.1f, 0.35f, false},
                                 {0.0f, 0.1f, 0.5f, true},    {0.0f, 0.1f, 0.5f, false},
                                 {-0.3f, 0.1f, 0.5f, false},  {0.0f, 0.1f, 2.0f, false},
                                 {-0.3f, 0.0f, 2.0f, true},   {-0.3f, 0.0f, 2.0f, false},
                                 {-0.7f, -0.3f, 2.0f, true},  {-0.7f, -0.3f, 2.0f, false},
                                 {-1.0f, -1.0f, 2.0f, false}};
constexpr std::size_t kAnnularAttempts = 5;
constexpr std::size_t kMostStarred = 16;  // corners of a gap that a vertex may close
constexpr int kAxisSteps = 4;             // along a gap's axis, as far as its corners are
constexpr int kNewtonSteps = 6;

}  // namespace

GapClosing GapCloser::run(std::span<const std::uint32_t> loop, bool annular,
                          std::span<const TakenChord> taken) {
  // One triangle that has its other side in the surface already.
  if (loop.size() == 3 && rim_.across(loop[0], loop[1]) == loop[2]) return {};
  load(loop);
  const GapPolygon polygon{points_, normals_, across_, chords_};
  float reach = 0;
  GapClosing closing;
  for (const Attempt& attempt :
       std::span(kAttempts, annular ? kAnnularAttempts : std::size(kAttempts))) {
    const GapRules rules{field_, attempt.least_cosine, attempt.middle_cosine, attempt.reach};
    if (attempt.reach != reach) find_chords(loop, taken, rules);
    reach = attempt.reach;
    const bool closed = attempt.star ? close_by_star(rules, closing.middle)
                                     : triangulator_.run(polygon, rules, mode_);
    if (!closed) continue;
    closing.kind = attempt.star ? GapClosing::starred : GapClosing::triangulated;
    closing.relaxed = &attempt != kAttempts;
    break;
  }
  return closing;
}

void GapCloser::load(std::span<const std::uint32_t> loop) {
  const std::size_t n = loop.size();
  points_.resize(n);
  normals_.resize(n);
  across_.resize(n);
  chords_.resize(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    points_[i] = vertex_at(mesh_, loop[i]);
    normals_[i] = rim_.normal(loop[i]);
    if (mode_ == StitchMode::paper) across_[i] = normal_across(loop[i], loop[(i + 1) % n]);
  }
}

Vec3 GapCloser::normal_across(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t c = rim_.across(a, b);
  if (c == GapRim::kNoVertex) return {};
  const Vec3 at = vertex_at(mesh_, a);
  return normalised(cross(vertex_at(mesh_, c) - at, vertex_at(mesh_, b) - at));
}

void GapCloser::find_chords(std::span<const std::uint32_t> loop, std::span<const TakenChord> taken,
                            const GapRules& rules) {
  const std::size_t n = loop.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j)
      chords_[n * i + j] = chords_[n * j + i] =
          j - i + 1 < n && loop[i] != loop[j] && !rim_.has_edge(loop[i], loop[j]) &&
          chord_follows_surface(rules, points_[i], points_[j]);
  for (const TakenChord& chord : taken)
    chords_[n * chord.i + chord.j] = chords_[n * chord.j + chord.i] = 0;
}

bool GapCloser::close_by_star(const GapRules& rules, Vec3& middle) const {
  const std::size_t n = points_.size();
  Vec3 normal;
  if (n > kMostStarred || !find_middle(middle, normal)) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    const Vec3 points[3] = {points_[i], points_[j], middle};
    const Vec3 normals[3] = {normals_[i], normals_[j], normal};
    if (!triangle_follows_surface(rules, points, normals)) return false;
  }
  return true;
}

/// Where the gap's axis (through the mean of its corners, along the vector of its area) meets the
/// surface: over a vessel's end, too, that is its tip.
bool GapCloser::find_middle(Vec3& middle, Vec3& normal) const {
  const std::size_t n = points_.size();
  Vec3 mean, axis;
  for (const Vec3& p : points_) mean = mean + p;
  mean = (1.0f / static_cast<float>(n)) * mean;
  float reach = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 to = points_[i] - mean;
    axis = axis + cross(to, points_[(i + 1) % n] - mean);
    reach = std::max(reach, norm(to));
  }
  FieldSample sample = sample_field(field_, mean);
  const bool inside = sample.value > 0;
  const float length = (inside ? reach : -reach) / static_cast<float>(kAxisSteps);
  const Vec3 step = length * normalised(axis);
  middle = mean;
  for (int i = 0; i < 2 * kAxisSteps && sample.known && (sample.value > 0) == inside; ++i) {
    middle = middle + step;
    sample = sample_field(field_, middle);
  }
  if (!sample.known || (sample.value > 0) == inside) return false;
  sample = project_to_surface(field_, reach, kNewtonSteps, middle);
  normal = normalised(-sample.gradient);
  return sample.known;
}

}  // namespace vasamesh

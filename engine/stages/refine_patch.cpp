#include "stages/refine_patch.h"

#include <algorithm>
#include <cmath>

namespace vasamesh {

namespace {

constexpr float kLeastFacing = 0.3f;    // of new triangles, or as little as the old ones had
constexpr float kGoodMeasure = 0.671f;  // of a least angle of 35 degrees
constexpr float kLeastSplit = 0.9f;     // edges shorter than this, in sizes, are never split
constexpr int kSettleRounds = 3;        // of flips and smoothing round a new vertex
constexpr int kMostImprovements = 8;    // vertices a patch gets for the sake of its angles
constexpr int kNewtonSteps = 6;

}  // namespace

void PatchRefiner::run(Patch& patch) {
  patch_ = &patch;
  rim_ = patch.rim;
  if (patch.triangles.size() < 6) return;
  link_triangles();
  const std::size_t most = rim_ + rim_ * rim_ / 4 + 16;
  for (std::uint32_t h; patch.points.size() < most && (h = longest_edge()) != kNone;)
    if (!insert(h)) ratio_[h] = ratio_[twin_[h]] = 0;
  for (int round = 0; round < kSettleRounds; ++round)
    for (std::size_t v = rim_; v < patch.points.size(); ++v) settle(static_cast<std::uint32_t>(v));
  improve_worst();
}

void PatchRefiner::link_triangles() {
  const auto count = static_cast<std::uint32_t>(patch_->triangles.size());
  twin_.assign(count, kNone);
  ratio_.assign(count, 0.0f);
  ends_.resize(count);
  for (std::uint32_t h = 0; h < count; ++h) ends_[h] = h;
  const auto low = [&](std::uint32_t h) { return std::min(from(h), to(h)); };
  const auto high = [&](std::uint32_t h) { return std::max(from(h), to(h)); };
  std::sort(ends_.begin(), ends_.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (low(a) != low(b)) return low(a) < low(b);
    return high(a) != high(b) ? high(a) < high(b) : a < b;
  });
  for (std::uint32_t i = 0; i + 1 < count; ++i) {
    const std::uint32_t a = ends_[i], b = ends_[i + 1];
    if (low(a) != low(b) || high(a) != high(b)) continue;
    twin_[a] = b;
    twin_[b] = a;
    ratio_[a] = ratio_[b] = length_ratio(a);
  }
}

float PatchRefiner::length_ratio(std::uint32_t h) const {
  const Vec3 &a = patch_->points[from(h)], &b = patch_->points[to(h)];
  const float size = size_at(sizes_, 0.5f * (a + b));
  return squared_norm(b - a) / (size * size);
}

void PatchRefiner::place(std::uint32_t triangle, const std::uint32_t (&corners)[3],
                         const std::uint32_t (&twins)[3]) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    patch_->triangles[3 * triangle + i] = corners[i];
    twin_[3 * triangle + i] = twins[i];
    if (twins[i] != kNone) twin_[twins[i]] = 3 * triangle + i;
  }
}

std::uint32_t PatchRefiner::longest_edge() const {
  const auto longest = std::max_element(ratio_.begin(), ratio_.end());
  return *longest > kLongest * kLongest ? static_cast<std::uint32_t>(longest - ratio_.begin())
                                        : kNone;
}

std::uint32_t PatchRefiner::longest_edge_of(std::uint32_t triangle) const {
  const auto first = ratio_.begin() + 3 * triangle;
  const auto longest = std::max_element(first, first + 3);
  return *longest > kLeastSplit * kLeastSplit ? static_cast<std::uint32_t>(longest - ratio_.begin())
                                              : kNone;
}

/// Cosine of the largest angle between a triangle's normal and the surface's at its corners.
float PatchRefiner::facing(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const auto& p = patch_->points;
  const auto& n = patch_->normals;
  const Vec3 normal = normalised(cross(p[b] - p[a], p[c] - p[a]));
  return std::min({dot(n[a], normal), dot(n[b], normal), dot(n[c], normal)});
}

bool PatchRefiner::insert(std::uint32_t h) {
  const std::uint32_t g = twin_[h], a = from(h), b = to(h), c = apex(h), d = apex(g);
  Vec3 at = 0.5f * (patch_->points[a] + patch_->points[b]);
  const float reach = 0.5f * norm(patch_->points[b] - patch_->points[a]);
  const FieldSample sample = project_to_surface(field_, reach, kNewtonSteps, at);
  if (!sample.known) return false;
  const float old = std::min(facing(a, b, c), facing(b, a, d));
  const auto v = static_cast<std::uint32_t>(patch_->points.size());
  patch_->points.push_back(at);
  patch_->normals.push_back(normalised(-sample.gradient));
  const float least = std::min(std::min(facing(a, v, c), facing(v, b, c)),
                               std::min(facing(b, v, d), facing(v, a, d)));
  if (least < std::min(kLeastFacing, old) || !(least > 0)) {
    patch_->points.pop_back();
    patch_->normals.pop_back();
    return false;
  }
  split(h, v);
  settle(v);
  return true;
}

void PatchRefiner::split(std::uint32_t h, std::uint32_t v) {
  const std::uint32_t g = twin_[h], a = from(h), b = to(h), c = apex(h), d = apex(g);
  const std::uint32_t bc = twin_[next(h)], ca = twin_[previous(h)], ad = twin_[next(g)],
                      db = twin_[previous(g)];
  const std::uint32_t t = h / 3, u = g / 3,
                      t2 = static_cast<std::uint32_t>(patch_->triangles.size() / 3), u2 = t2 + 1;
  patch_->triangles.resize(patch_->triangles.size() + 6);
  twin_.resize(patch_->triangles.size(), kNone);
  ratio_.resize(patch_->triangles.size(), 0.0f);
  place(t, {a, v, c}, {3 * u2, 3 * t2 + 2, ca});
  place(t2, {v, b, c}, {3 * u, bc, 3 * t + 1});
  place(u, {b, v, d}, {3 * t2, 3 * u2 + 2, db});
  place(u2, {v, a, d}, {3 * t, ad, 3 * u + 1});
  for (const std::uint32_t triangle : {t, t2, u, u2})
    for (std::uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e)
      ratio_[e] = twin_[e] == kNone ? 0 : length_ratio(e);
}

/// The half edges that leave an inserted vertex, counter-clockwise.
void PatchRefiner::collect_fan(std::uint32_t vertex) {
  const auto found = std::find(patch_->triangles.begin(), patch_->triangles.end(), vertex);
  const auto start = static_cast<std::uint32_t>(found - patch_->triangles.begin());
  fan_.clear();
  std::uint32_t h = start;
  do {
    fan_.push_back(h);
    h = twin_[previous(h)];
  } while (h != start);
}

void PatchRefiner::settle(std::uint32_t vertex) {
  for (int round = 0; round < kSettleRounds; ++round) {
    bool changed = false;
    for (std::size_t flips = 0; flips < patch_->triangles.size() && flip_opposite(vertex); ++flips)
      changed = true;
    changed |= smooth(vertex);
    if (!changed) break;
  }
}

/// Flips one edge across from the vertex. \return whether one wanted it.
bool PatchRefiner::flip_opposite(std::uint32_t vertex) {
  collect_fan(vertex);
  for (const std::uint32_t leaving : fan_) {
    const std::uint32_t h = next(leaving);
    if (twin_[h] == kNone || !wants_flip(h)) continue;
    flip(h);
    return true;
  }
  return false;
}

/// Whether the angles across from the edge sum to more than pi, and the edge may be flipped.
bool PatchRefiner::wants_flip(std::uint32_t h) const {
  const std::uint32_t a = from(h), b = to(h), c = apex(h), d = apex(twin_[h]);
  const auto& p = patch_->points;
  const Vec3 ca = p[a] - p[c], cb = p[b] - p[c], da = p[a] - p[d], db = p[b] - p[d];
  const float sine_c = norm(cross(ca, cb)), sine_d = norm(cross(da, db));
  const float cosine_c = dot(ca, cb), cosine_d = dot(da, db);
  const float sum = sine_c * cosine_d + cosine_c * sine_d;
  const float scale = sine_c * std::abs(cosine_d) + std::abs(cosine_c) * sine_d;
  if (!(sum < -1e-3f * scale)) return false;
  const float old = std::min(facing(a, b, c), facing(b, a, d));
  const float flipped = std::min(facing(d, b, c), facing(c, a, d));
  return flipped >= std::min(kLeastFacing, old) && flipped > 0 && !are_joined(c, d);
}

bool PatchRefiner::are_joined(std::uint32_t a, std::uint32_t b) const {
  for (std::uint32_t h = 0; h < patch_->triangles.size(); ++h)
    if ((from(h) == a && to(h) == b) || (from(h) == b && to(h) == a)) return true;
  return false;
}

void PatchRefiner::flip(std::uint32_t h) {
  const std::uint32_t g = twin_[h], a = from(h), b = to(h), c = apex(h), d = apex(g);
  const std::uint32_t bc = twin_[next(h)], ca = twin_[previous(h)], ad = twin_[next(g)],
                      db = twin_[previous(g)];
  const std::uint32_t t = h / 3, u = g / 3;
  place(t, {d, b, c}, {db, bc, 3 * u + 2});
  place(u, {c, a, d}, {ca, ad, 3 * t + 2});
  for (const std::uint32_t triangle : {t, u})
    for (std::uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e)
      ratio_[e] = twin_[e] == kNone ? 0 : length_ratio(e);
}

float PatchRefiner::measure(std::uint32_t triangle) const {
  const std::uint32_t* t = patch_->triangles.data() + 3 * triangle;
  return least_angle_measure(patch_->points[t[0]], patch_->points[t[1]], patch_->points[t[2]]);
}

float PatchRefiner::worst_of_fan() const {
  float worst = 0;
  for (const std::uint32_t h : fan_) worst = std::max(worst, measure(h / 3));
  return worst;
}

/// Moves an inserted vertex to the mean of its neighbours, projected, where that makes the worst
/// of its triangles better.
bool PatchRefiner::smooth(std::uint32_t vertex) {
  collect_fan(vertex);
  const Vec3 old = patch_->points[vertex], old_normal = patch_->normals[vertex];
  Vec3 mean;
  float least = 1;
  for (const std::uint32_t h : fan_) {
    mean = mean + patch_->points[to(h)];
    least = std::min(least, facing(from(h), to(h), apex(h)));
  }
  mean = (1.0f / static_cast<float>(fan_.size())) * mean;
  const float before = worst_of_fan();
  const float reach = norm(patch_->points[to(fan_[0])] - mean);
  const FieldSample sample = project_to_surface(field_, reach, kNewtonSteps, mean);
  if (!sample.known) return false;
  patch_->points[vertex] = mean;
  patch_->normals[vertex] = normalised(-sample.gradient);
  bool better = worst_of_fan() < 0.999f * before;
  for (std::size_t i = 0; i < fan_.size() && better; ++i)
    better = facing(from(fan_[i]), to(fan_[i]), apex(fan_[i])) >= std::min(kLeastFacing, least);
  if (!better) {
    patch_->points[vertex] = old;
    patch_->normals[vertex] = old_normal;
    return false;
  }
  for (const std::uint32_t h : fan_) ratio_[h] = ratio_[twin_[h]] = length_ratio(h);
  return true;
}

std::uint32_t PatchRefiner::worst_triangle() const {
  std::uint32_t worst = 0;
  float most = 0;
  for (std::uint32_t t = 0; t < patch_->triangles.size() / 3; ++t) {
    const float here = measure(t);
    if (!(here > most)) continue;
    most = here;
    worst = t;
  }
  return worst;
}

/// Tries a vertex on the longest edge of the worst triangle, and keeps it where the worst triangle
/// of the patch is better for it.
void PatchRefiner::improve_worst() {
  for (int trial = 0; trial < kMostImprovements; ++trial) {
    const std::uint32_t triangle = worst_triangle();
    const float before = measure(triangle);
    if (before <= kGoodMeasure) return;
    const std::uint32_t h = longest_edge_of(triangle);
    if (h == kNone) return;
    saved_patch_ = *patch_;
    saved_twin_ = twin_;
    saved_ratio_ = ratio_;
    if (!insert(h)) return;
    for (std::size_t v = rim_; v < patch_->points.size(); ++v)
      settle(static_cast<std::uint32_t>(v));
    if (measure(worst_triangle()) < 0.95f * before) continue;
    std::swap(*patch_, saved_patch_);
    twin_.swap(saved_twin_);
    ratio_.swap(saved_ratio_);
    return;
  }
}

}  // namespace vasamesh

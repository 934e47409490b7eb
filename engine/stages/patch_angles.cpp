/// Small angles made wider by geometry alone.

#include <algorithm>
#include <cmath>
#include <optional>

#include "stages/patch_clearance.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kWanted = 1.05f * kSine20;  // a little more than is asked for
constexpr float kGain = 1.01f;              // the least by which a squared sine must grow
constexpr float kFirstStep = 0.3f, kLastStep = 0.01f;  // of the mean edge round a vertex

Vec3 area_vector(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
  return cross(b.position - a.position, c.position - a.position);
}

class Widening {
 public:
  explicit Widening(PatchMesh& mesh) : mesh_(mesh), clearance_(mesh) {}

  /// One try at a triangle: an edge turned, or else its corners moved.
  void widen(std::uint32_t first) {
    const std::uint32_t corners[3] = {mesh_.origin(first), mesh_.target(first), mesh_.apex(first)};
    for (std::uint32_t h = first; h < first + 3; ++h)
      if (try_flip(h)) return;
    for (const std::uint32_t v : corners)
      if (mesh_.is_inner(v)) move(v);
  }

 private:
  float fan_sine(std::uint32_t v, const SurfacePoint& point) const;
  float mean_edge(std::uint32_t v) const;
  bool try_flip(std::uint32_t h);
  void move(std::uint32_t v);

  PatchMesh& mesh_;
  Clearance clearance_;
};

/// The least squared sine of the triangles round v with `point` in its place; -1 where one of them
/// turns by 90 degrees or more.
float Widening::fan_sine(std::uint32_t v, const SurfacePoint& point) const {
  float least = 1;
  mesh_.for_each_out(v, [&](std::uint32_t h) {
    const SurfacePoint &b = mesh_.points[mesh_.target(h)], &c = mesh_.points[mesh_.apex(h)];
    const bool turns = !(dot(area_vector(point, b, c), area_vector(mesh_.points[v], b, c)) > 0);
    least = std::min(least, turns ? -1 : least_sine(point, b, c));
  });
  return least;
}

float Widening::mean_edge(std::uint32_t v) const {
  float sum = 0, count = 0;
  mesh_.for_each_out(v, [&](std::uint32_t h) {
    sum += norm(mesh_.points[mesh_.target(h)].position - mesh_.points[v].position);
    ++count;
  });
  return sum / count;
}

bool Widening::try_flip(std::uint32_t h) {
  const std::uint32_t t = mesh_.twin(h);
  if (t == PatchMesh::kNone || !mesh_.may_flip(h)) return false;
  const SurfacePoint &p = mesh_.points[mesh_.origin(h)], &q = mesh_.points[mesh_.target(h)],
                     &c = mesh_.points[mesh_.apex(h)], &d = mesh_.points[mesh_.apex(t)];
  const float before = std::min(least_sine(mesh_, h), least_sine(mesh_, t));
  if (!(std::min(least_sine(d, c, p), least_sine(c, d, q)) > kGain * before)) return false;
  const Vec3 old = area_vector(p, q, c) + area_vector(q, p, d);
  return dot(area_vector(d, c, p), old) > 0 && dot(area_vector(c, d, q), old) > 0 &&
         clearance_.flip_if_clear(mesh_, h);
}

/// Search in all directions for the place of v with the widest least angle round it.
void Widening::move(std::uint32_t v) {
  SurfacePoint best = mesh_.points[v];
  const float before = fan_sine(v, best), edge = mean_edge(v);
  float widest = before;
  for (float step = kFirstStep; step > kLastStep;) {
    const Vec3 from = best.position;
    for (int i = 0; i < 27; ++i) {
      const Vec3 way = {static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1),
                        static_cast<float>(i / 9 - 1)};
      SurfacePoint point = best;
      point.position = from + (step * edge) * way;
      const float sine = fan_sine(v, point);
      if (!(sine > kGain * widest && sine > widest)) continue;
      widest = sine;
      best = point;
    }
    if (best.position == from) step *= 0.5f;
  }
  best.on_field = false;
  if (widest > before) clearance_.move_if_clear(mesh_, v, best);
}

}  // namespace

void widen_angles(PatchMesh& mesh, int passes) {
  std::optional<Widening> work;
  for (int pass = 0; pass < passes; ++pass) {
    bool any = false;
    for (std::uint32_t t = 0; t < mesh.half_edge_end(); t += 4) {
      if (!mesh.is_edge(t) || least_sine(mesh, t) >= kWanted) continue;
      if (!work) work.emplace(mesh);
      work->widen(t);
      any = true;
    }
    if (!any) return;
  }
}

}  // namespace vasamesh

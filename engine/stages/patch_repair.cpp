/// Repair of the worst triangles.

#include <cmath>
#include <optional>
#include <vector>

#include "stages/compass.h"
#include "stages/fan_moves.h"
#include "stages/patch_clearance.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"
#include "types/least_most.h"

namespace vasamesh {

namespace {

constexpr float kReach = 0.3f;  // voxel lengths that the projection may move a vertex
constexpr float kGain = 1.01f;  // the least by which a squared sine must grow

// Relaxation of crumpled places: needles are first made wider (each third time gaps are), then
// smoothed without shrinking (Taubin: A signal processing approach to fair surface design, 1995).
constexpr float kInflation = 0.1f;               // voxel lengths
constexpr int kRelaxations = 6;                  // steps, shrinking and growing in turn
constexpr float kShrink = 0.5f, kGrow = -0.52f;  // of the way to the mean of the neighbours
constexpr float kMostRelaxed = 0.5f;             // voxel lengths that a vertex may move so in all

float quality_of(const PatchMesh& mesh, std::uint32_t h) {
  return triangle_quality(mesh.points[mesh.origin(h)], mesh.points[mesh.target(h)],
                          mesh.points[mesh.apex(h)], kLeastFacingInRepair);
}

/// The quality of a triangle with corners a, b, c, its least cosine with their normals being
/// `facing` over the length of `normal` (triangle_quality()).
float quality_from(float ab, float bc, float ca, float squared_cross, float facing) {
  const float longest_two = most(most(ab * bc, bc * ca), ca * ab);
  const float squared_sine = longest_two > 0 ? squared_cross / longest_two : 0.0f;
  const float turned = squared_cross > 0 ? facing / std::sqrt(squared_cross) - 1 : -2.0f;
  const bool faces = (facing > 0) & (facing * facing >=
                                     kLeastFacingInRepair * kLeastFacingInRepair * squared_cross);
  return faces ? squared_sine : turned;
}

/// fan_quality() in repairs with a vertex of that normal in each of the places.
CompassValues fan_qualities(const Ring& ring, const Vec3& normal, const CompassPlaces& places) {
  const CompassPlaces at = places;
  const Vec3 own = normal;
  CompassValues worst;
  worst.fill(1);
  for (std::size_t i = 0; i < ring.triangles(); ++i) {
    const SurfacePoint b = ring[i], c = ring[i + 1];
    const Vec3 bc = c.position - b.position;
    const float squared_bc = squared_norm(bc);
    for (std::size_t k = 0; k < kCompass.size(); ++k) {
      const Vec3 a = at[k], ab = b.position - a, ca = a - c.position, n = cross(ab, bc);
      const float facing = least(least(dot(n, own), dot(n, b.normal)), dot(n, c.normal));
      worst[k] = least(worst[k], quality_from(squared_norm(ab), squared_bc, squared_norm(ca),
                                              squared_norm(n), facing));
    }
  }
  return worst;
}

class Repair {
 public:
  /// \param fresh  a byte a triangle: set where one changes.
  Repair(PatchMesh& mesh, const RemeshGoal& goal, std::vector<std::uint8_t>& fresh)
      : mesh_(mesh), goal_(goal), fresh_(fresh), clearance_(mesh) {}

  /// One try at a triangle: its longest edge turned, its shortest away, its corners moved.
  void repair_triangle(std::uint32_t first) {
    std::uint32_t shortest = first, longest = first;
    float least = length_of(first), most = least;
    for (std::uint32_t h = first + 1; h < first + 3; ++h) {
      const float length = length_of(h);
      if (length < least) least = length, shortest = h;
      if (length > most) most = length, longest = h;
    }
    const std::uint32_t corners[3] = {mesh_.apex(longest), mesh_.origin(longest),
                                      mesh_.target(longest)};
    if (try_flip(longest) || try_collapse(shortest)) return;
    for (std::uint32_t v : corners) try_move(v);
  }

  void relax(float wanted);

 private:
  static float quality(const SurfacePoint& a, const SurfacePoint& b, const SurfacePoint& c) {
    return triangle_quality(a, b, c, kLeastFacingInRepair);
  }
  float length_of(std::uint32_t h) const {
    return squared_norm(mesh_.points[mesh_.target(h)].position -
                        mesh_.points[mesh_.origin(h)].position);
  }
  float fan_of(std::uint32_t v, const SurfacePoint& point) const {
    return fan_quality(mesh_, v, point, kLeastFacingInRepair);
  }

  std::vector<std::uint32_t> vertices_near_bad(float wanted) const;
  bool try_flip(std::uint32_t h);
  bool try_collapse(std::uint32_t h);
  bool try_move(std::uint32_t v);
  bool move(std::uint32_t v, const SurfacePoint& point);
  float merged_quality(std::uint32_t gone, std::uint32_t kept) const;
  void take_fan(std::uint32_t v, std::uint32_t point);

  PatchMesh& mesh_;
  const RemeshGoal& goal_;
  std::vector<std::uint8_t>& fresh_;
  Clearance clearance_;
  int relaxations_ = 0;
  std::vector<std::uint32_t> gone_, ring_;
  std::vector<Clearance::Corners> made_;
};

bool Repair::try_flip(std::uint32_t h) {
  const std::uint32_t t = mesh_.twin(h);
  if (t == PatchMesh::kNone || !mesh_.may_flip(h)) return false;
  const std::uint32_t p = mesh_.origin(h), q = mesh_.target(h), c = mesh_.apex(h),
                      d = mesh_.apex(t);
  const float before = std::min(quality_of(mesh_, h), quality_of(mesh_, t));
  const float after = std::min(quality(mesh_.points[d], mesh_.points[c], mesh_.points[p]),
                               quality(mesh_.points[c], mesh_.points[d], mesh_.points[q]));
  if (!(after > kGain * before) || !(after > before)) return false;
  if (!clearance_.flip_if_clear(mesh_, h)) return false;
  fresh_[h / 4] = fresh_[t / 4] = 1;
  return true;
}

/// The least quality of the fan of `gone` once merged into `kept`; -2 where a triangle turns away.
float Repair::merged_quality(std::uint32_t gone, std::uint32_t kept) const {
  float least = 1;
  mesh_.for_each_out(gone, [&](std::uint32_t h) {
    const std::uint32_t b = mesh_.target(h), c = mesh_.apex(h);
    if (b == kept || c == kept) return;
    least = std::min(least, quality(mesh_.points[kept], mesh_.points[b], mesh_.points[c]));
    if (!may_replace(mesh_.points[gone], mesh_.points[kept], mesh_.points[b], mesh_.points[c], 0,
                     kLeastFacingInRepair))
      least = -2;
  });
  return least;
}

/// The fan of `v` and its triangles with `point` for v, without those that have both of them.
void Repair::take_fan(std::uint32_t v, std::uint32_t point) {
  gone_.clear();
  made_.clear();
  mesh_.for_each_out(v, [&](std::uint32_t h) {
    const std::uint32_t b = mesh_.target(h), c = mesh_.apex(h);
    gone_.push_back(h);
    if (b != point && c != point) made_.push_back({point, b, c});
  });
}

bool Repair::try_collapse(std::uint32_t h) {
  const std::uint32_t ends[2] = {mesh_.origin(h), mesh_.target(h)};
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t gone = ends[i], kept = ends[1 - i];
    if (!mesh_.is_whole(gone) || !mesh_.is_whole(kept)) continue;
    const float before = fan_of(gone, mesh_.points[gone]);
    const float after = merged_quality(gone, kept);
    if (!(after > kGain * before) || !(after > before)) continue;
    if (!mesh_.may_collapse(h, gone, kept)) continue;
    take_fan(gone, kept);
    if (!clearance_.is_clear(mesh_, gone_, made_)) continue;
    mesh_.collapse(h, gone, kept);
    for (std::uint32_t g : gone_) {
      fresh_[g / 4] = 1;
      if (mesh_.is_edge(g)) clearance_.take_up(mesh_, g);
    }
    return true;
  }
  return false;
}

bool Repair::move(std::uint32_t v, const SurfacePoint& point) {
  if (!clearance_.move_if_clear(mesh_, v, point)) return false;
  mesh_.for_each_out(v, [&](std::uint32_t h) { fresh_[h / 4] = 1; });
  return true;
}

/// Compass search for the place of v with the best fan.
bool Repair::try_move(std::uint32_t v) {
  if (!mesh_.is_inner(v)) return false;
  ring_.clear();
  mesh_.for_each_out(v, [&](std::uint32_t h) { ring_.push_back(mesh_.target(h)); });
  ring_.push_back(ring_.front());
  const Ring ring = {mesh_.points.data(), ring_};
  const SurfacePoint old = mesh_.points[v];
  SurfacePoint place = old;
  const float before = fan_quality(ring, old, kLeastFacingInRepair);
  float best = before;
  for (float step = 0.2f; step > 0.02f;) {
    const SurfacePoint from = place;
    const auto consider = [&](const Vec3& position) {
      SurfacePoint point = from;
      point.position = position;
      if (from.on_field && !put_onto_surface(goal_, kReach, point)) return;
      const float found = fan_quality(ring, point, kLeastFacingInRepair);
      if (!(found > best + 1e-4f) || !may_move(old, ring, point, 0, kLeastFacingInRepair)) return;
      best = found;
      place = point;
    };
    const CompassPlaces places =
        compass_round(from.position, step * from.size, tangents(from.normal));
    const CompassValues qualities = fan_qualities(ring, from.normal, places);
    for (std::size_t k = 0; k < kCompass.size(); ++k)
      if (qualities[k] > best) consider(places[k]);
    if (!from.on_field) {
      consider(from.position + (step * from.size) * (0.5f * from.normal));
      consider(from.position + (step * from.size) * (-0.5f * from.normal));
    }
    if (place.position == from.position) step *= 0.5f;
  }
  return best > before && move(v, place);
}

/// Whole inner vertices within two edges of the triangles that are worse than `wanted`.
std::vector<std::uint32_t> Repair::vertices_near_bad(float wanted) const {
  std::vector<std::uint8_t> near(mesh_.vertex_count(), 0);
  for (std::uint32_t t = 0; t < mesh_.half_edge_end(); t += 4) {
    mesh_.take_turn();
    if (mesh_.is_edge(t) && quality_of(mesh_, t) < wanted)
      for (std::uint32_t h = t; h < t + 3; ++h) near[mesh_.origin(h)] = 1;
  }
  for (std::uint8_t ring = 1; ring <= 2; ++ring)
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (near[v] != ring || !mesh_.is_whole(v)) continue;
      mesh_.for_each_out(v, [&](std::uint32_t h) {
        for (std::uint32_t w : {mesh_.target(h), mesh_.apex(h)})
          if (!near[w]) near[w] = ring + 1;
      });
    }
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
    if (near[v] && mesh_.is_there(v) && mesh_.is_inner(v)) vertices.push_back(v);
  return vertices;
}

/// Smooths the places of the worst triangles as a membrane, off the field, where nothing comes to
/// meet: they lie where the surface is crumpled at the scale of its edges.
void Repair::relax(float wanted) {
  const std::vector<std::uint32_t> vertices = vertices_near_bad(wanted);
  std::vector<Vec3> start;
  for (std::uint32_t v : vertices) start.push_back(mesh_.points[v].position);
  const float inflation = relaxations_++ % 3 == 2 ? -kInflation : kInflation;
  for (std::uint32_t v : vertices) {
    SurfacePoint point = mesh_.points[v];
    point.normal = fan_normal(mesh_, v);
    point.position = point.position + inflation * point.normal;
    if (point.drift + kInflation > kMostRelaxed) continue;
    clearance_.move_if_clear(mesh_, v, point);
  }
  for (int pass = 0; pass < kRelaxations; ++pass)
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      SurfacePoint point = mesh_.points[vertices[i]];
      Vec3 sum;
      float count = 0;
      mesh_.for_each_out(vertices[i], [&](std::uint32_t h) {
        sum = sum + mesh_.points[mesh_.target(h)].position;
        ++count;
      });
      const float part = pass % 2 == 0 ? kShrink : kGrow;
      point.position = point.position + part * ((1 / count) * sum - point.position);
      if (point.drift + norm(point.position - start[i]) > kMostRelaxed) continue;
      clearance_.move_if_clear(mesh_, vertices[i], point);
    }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    SurfacePoint& point = mesh_.points[vertices[i]];
    point.drift += norm(point.position - start[i]);
    point.on_field = false;
    point.normal = fan_normal(mesh_, vertices[i]);
    mesh_.for_each_out(vertices[i], [&](std::uint32_t h) { fresh_[h / 4] = 1; });
  }
}

}  // namespace

std::uint32_t repair(PatchMesh& mesh, const RemeshGoal& goal, float wanted, int passes) {
  constexpr int kPassesBetween = 4;  // relaxations
  // A byte a triangle: whether it has changed since it was found good, or is not.
  std::vector<std::uint8_t> fresh(mesh.half_edge_end() / 4, 1);
  std::optional<Repair> work;
  for (int pass = 0;; ++pass) {
    std::uint32_t left = 0;
    float worst = 1;
    for (std::uint32_t t = 0; t < mesh.half_edge_end(); t += 4) {
      mesh.take_turn();
      if (!fresh[t / 4]) continue;
      const float quality = mesh.is_edge(t) ? quality_of(mesh, t) : 1.0f;
      fresh[t / 4] = quality < wanted;
      if (quality >= wanted) continue;
      ++left;
      worst = std::min(worst, quality);
      if (pass == passes) continue;
      if (!work) work.emplace(mesh, goal, fresh);
      work->repair_triangle(t);
    }
    if (left == 0 || pass == passes) return left;
    if (pass % kPassesBetween != kPassesBetween - 1) continue;
    if (worst >= kSquaredSine20) return left;
    work->relax(std::min(wanted, kSquaredSine20));
  }
}

}  // namespace vasamesh

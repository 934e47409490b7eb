#include "stages/settle.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>

#include "stages/approach.h"
#include "stages/distance.h"
#include "stages/patch_rules.h"
#include "stages/places.h"
#include "stages/remesh.h"
#include "types/mesh_vertex.h"

namespace vasamesh {

namespace {

constexpr float kFarShare = 0.94f;   // of the limit: what is too far
constexpr float kNearShare = 0.85f;  // of the limit: how near the surface is brought
constexpr float kStray = 0.4f;       // voxel lengths: of a vertex from the base surface, at most
constexpr float kSpread = 4;         // voxel lengths beyond a place that its work may reach
constexpr float kFactors[] = {0.8f, 0.65f, 0.5f};  // of the edges, round by round

class Settling {
 public:
  Settling(Backend& backend, const FieldView& field, const SizeView& sizes, const Bounds& bounds)
      : backend_(backend), field_(field), sizes_(sizes), bounds_(bounds) {}

  /// The vertices near the places brought back to the base surface and to marching cubes, then the
  /// surface there to all of marching cubes.
  TriangleMesh approached(const Places& places, TriangleMesh mesh) const {
    const float near = kNearShare * bounds_.limit;
    mesh = bring_back(backend_, field_, sizes_, bounds_.base, bounds_.base_tree, kStray,
                      std::move(mesh), places);
    mesh = bring_back(backend_, field_, sizes_, bounds_.solid, bounds_.solid_tree, near,
                      std::move(mesh), places);
    const std::vector<Vec3> far = points_beyond(backend_, near, bounds_.solid, mesh,
                                                build_triangle_tree(backend_, mesh), places);
    return approach(backend_, field_, sizes_, far, near, std::move(mesh));
  }

  /// The points too far: those that were known before away from the places, and those near them.
  std::vector<Vec3> far_points(const Places& places, const TriangleMesh& mesh,
                               const std::vector<Vec3>& known) const {
    const float most = kFarShare * bounds_.limit;
    std::vector<Vec3> far;
    if (!places.empty())
      std::copy_if(known.begin(), known.end(), std::back_inserter(far),
                   [&](const Vec3& p) { return !places.hold(p, Places::kMargin); });
    const TriangleTree tree = build_triangle_tree(backend_, mesh);
    for (const std::vector<Vec3>& found :
         {points_beyond(backend_, most, bounds_.solid, mesh, tree, places),
          points_beyond(backend_, most, mesh, bounds_.solid, bounds_.solid_tree, places)})
      far.insert(far.end(), found.begin(), found.end());
    return far;
  }

  TriangleMesh remeshed(const TriangleMesh& mesh, std::span<const CarefulPlace> places) const {
    return remesh_places(backend_, field_, sizes_, mesh, places);
  }

 private:
  Backend& backend_;
  const FieldView& field_;
  const SizeView& sizes_;
  const Bounds& bounds_;
};

/// The centres of the triangles with an angle below 20 degrees.
std::vector<Vec3> poor_triangles(const TriangleMesh& mesh) {
  std::vector<Vec3> found;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::uint32_t* v = &mesh.triangles[3 * t];
    const Vec3 a = vertex_at(mesh, v[0]), b = vertex_at(mesh, v[1]), c = vertex_at(mesh, v[2]);
    if (least_sine(squared_norm(b - a), squared_norm(c - b), squared_norm(a - c),
                   squared_norm(cross(b - a, c - a))) < kSine20)
      found.push_back((1.0f / 3) * ((a + b) + c));
  }
  return found;
}

/// The places and what work in them may reach.
Places spread(std::span<const CarefulPlace> places) {
  std::vector<CarefulPlace> wider(places.begin(), places.end());
  for (CarefulPlace& place : wider) place.radius += kSpread;
  return Places(wider);
}

}  // namespace

Settled settle(Backend& backend, const FieldView& field, const SizeView& sizes,
               const Bounds& bounds, float radius, TriangleMesh mesh,
               std::span<const CarefulPlace> within, const std::vector<Vec3>& far) {
  if (mesh.triangles.empty()) return {std::move(mesh), {}};
  const Settling settling(backend, field, sizes, bounds);
  mesh = settling.approached(Places(within), std::move(mesh));
  Settled now = {mesh, settling.far_points(spread(within), mesh, far)};
  std::vector<Vec3> poor = poor_triangles(mesh);
  Settled best = now;
  std::pair<std::size_t, std::size_t> least = {now.far.size(), poor.size()};
  for (const float factor : kFactors) {
    if (now.far.empty() && poor.empty()) break;
    poor.insert(poor.end(), now.far.begin(), now.far.end());
    const std::vector<CarefulPlace> careful = places_at(poor, radius, factor);
    now.mesh = settling.approached(Places(careful), settling.remeshed(now.mesh, careful));
    now.far = settling.far_points(spread(careful), now.mesh, now.far);
    poor = poor_triangles(now.mesh);
    const std::pair<std::size_t, std::size_t> left = {now.far.size(), poor.size()};
    if (left >= least) continue;
    least = left;
    best = now;
  }
  return best;
}

}  // namespace vasamesh

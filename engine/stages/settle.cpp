#include "stages/settle.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>

#include "stages/approach.h"
#include "stages/distance.h"
#include "stages/intersect.h"
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
constexpr float kFactors[] = {0.8f, 0.65f, 0.5f, 0.7f, 0.55f};  // of the edges, round by round

/// What is wrong with a surface, and where.
struct Faults {
  std::vector<Vec3> meeting;  ///< where triangles meet that should not
  std::vector<Vec3> far;      ///< points of either that are too far from the other
  std::vector<Vec3> poor;     ///< triangles with an angle below 20 degrees

  /// The worst first.
  std::array<std::size_t, 3> counts() const { return {meeting.size(), far.size(), poor.size()}; }

  std::vector<Vec3> all() const {
    std::vector<Vec3> points = meeting;
    points.insert(points.end(), far.begin(), far.end());
    points.insert(points.end(), poor.begin(), poor.end());
    return points;
  }
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

  /// \param places  if any: where the mesh is new. \param known  points too far before.
  Faults faults_of(const TriangleMesh& mesh, const Places& places,
                   const std::vector<Vec3>& known) const {
    const float most = kFarShare * bounds_.limit;
    Faults faults;
    if (!places.empty())
      std::copy_if(known.begin(), known.end(), std::back_inserter(faults.far),
                   [&](const Vec3& p) { return !places.hold(p, Places::kMargin); });
    const TriangleTree tree = build_triangle_tree(backend_, mesh);
    for (const std::vector<Vec3>& found :
         {points_beyond(backend_, most, bounds_.solid, mesh, tree, places),
          points_beyond(backend_, most, mesh, bounds_.solid, bounds_.solid_tree, places)})
      faults.far.insert(faults.far.end(), found.begin(), found.end());
    faults.meeting = centres_of(mesh, find_intersections(backend_, mesh, tree).pairs);
    faults.poor = poor_triangles(mesh);
    return faults;
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
  Faults faults = settling.faults_of(mesh, spread(within), far);
  Settled best = {mesh, faults.far};
  auto least = faults.counts();
  for (const float factor : kFactors) {
    const std::vector<Vec3> spots = faults.all();
    if (spots.empty()) break;
    const std::vector<CarefulPlace> places = places_at(spots, radius, factor);
    mesh = settling.approached(Places(places), settling.remeshed(mesh, places));
    faults = settling.faults_of(mesh, spread(places), faults.far);
    if (faults.counts() >= least) continue;
    least = faults.counts();
    best = {mesh, faults.far};
  }
  return best;
}

}  // namespace vasamesh

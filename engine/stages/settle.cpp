#include "stages/settle.h"

#include <cstddef>
#include <cstdint>
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
constexpr float kFactors[] = {0.8f, 0.65f, 0.5f};  // of the edges, round by round

class Settling {
 public:
  Settling(Backend& backend, const FieldView& field, const SizeView& sizes, const Bounds& bounds)
      : backend_(backend), field_(field), sizes_(sizes), bounds_(bounds) {}

  /// The vertices brought back to the base surface and to marching cubes, then the surface to all
  /// of marching cubes.
  TriangleMesh approached(TriangleMesh mesh) const {
    const float near = kNearShare * bounds_.limit;
    mesh = bring_back(backend_, field_, sizes_, bounds_.base, bounds_.base_tree, kStray,
                      std::move(mesh));
    mesh = bring_back(backend_, field_, sizes_, bounds_.solid, bounds_.solid_tree, near,
                      std::move(mesh));
    const std::vector<Vec3> far =
        points_beyond(backend_, near, bounds_.solid, mesh, build_triangle_tree(backend_, mesh));
    return approach(backend_, field_, sizes_, far, near, std::move(mesh));
  }

  std::vector<Vec3> far_points(const TriangleMesh& mesh) const {
    const float most = kFarShare * bounds_.limit;
    std::vector<Vec3> far =
        points_beyond(backend_, most, bounds_.solid, mesh, build_triangle_tree(backend_, mesh));
    const std::vector<Vec3> own =
        points_beyond(backend_, most, mesh, bounds_.solid, bounds_.solid_tree);
    far.insert(far.end(), own.begin(), own.end());
    return far;
  }

  TriangleMesh remeshed(const TriangleMesh& mesh, std::vector<Vec3> spots, float radius,
                        float factor) const {
    return remesh_places(backend_, field_, sizes_, mesh, places_at(spots, radius, factor));
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

}  // namespace

Settled settle(Backend& backend, const FieldView& field, const SizeView& sizes,
               const Bounds& bounds, float radius, TriangleMesh mesh) {
  if (mesh.triangles.empty()) return {std::move(mesh), {}};
  const Settling settling(backend, field, sizes, bounds);
  mesh = settling.approached(std::move(mesh));
  std::vector<Vec3> far = settling.far_points(mesh), poor = poor_triangles(mesh);
  Settled best = {mesh, far};
  std::pair<std::size_t, std::size_t> least = {far.size(), poor.size()};
  for (const float factor : kFactors) {
    if (far.empty() && poor.empty()) break;
    poor.insert(poor.end(), far.begin(), far.end());
    mesh = settling.approached(settling.remeshed(mesh, std::move(poor), radius, factor));
    far = settling.far_points(mesh);
    poor = poor_triangles(mesh);
    if (std::pair{far.size(), poor.size()} >= least) continue;
    least = {far.size(), poor.size()};
    best = {mesh, far};
  }
  return best;
}

}  // namespace vasamesh

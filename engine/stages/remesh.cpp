#include "stages/remesh.h"

#include "stages/finish.h"
#include "stages/patch_blocks.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"
#include "stages/triangle_tree.h"

namespace vasamesh {

namespace {

constexpr float kFineBlock = 16, kBlock = 32;  // voxel lengths
constexpr int kRounds = 5;
constexpr int kRepairedRounds = 2;  // the last ones

/// A vertex removed is one that the next rounds need not look at: from the shortest edges up.
constexpr float kCoarsening[] = {0.3f, 0.5f, 0.7f, kShortest};

/// Points within places where the input stays.
void fix_places(const RemeshGoal& goal, WorkingSurface& surface) {
  bool any = false;
  for (const CarefulPlace& place : goal.places) any |= place.factor == 0;
  if (!any) return;
  surface.fixed.resize(surface.points.size());
  for (std::size_t v = 0; v < surface.points.size(); ++v)
    surface.fixed[v] = goal.size_at(surface.points[v].position) == 0;
}

std::int64_t count_pairs(Backend& backend, const TriangleMesh& mesh,
                         std::vector<TrianglePair>& pairs) {
  Intersections found =
      find_intersections(backend, mesh, build_triangle_tree(backend, mesh));
  pairs = std::move(found.pairs);
  return found.count;
}

}  // namespace

TriangleMesh remesh(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh, std::span<const CarefulPlace> places) {
  const RemeshGoal goal = {field, sizes, places};
  WorkingSurface surface = make_working_surface(backend, goal, mesh);
  fix_places(goal, surface);
  for_each_block(backend, {kFineBlock, 0.5f}, surface, [](PatchMesh& part) {
    for (float shortest : kCoarsening) collapse_short_edges(part, shortest, kLongest);
  });
  for (int round = 0; round < kRounds; ++round)
    for_each_block(backend, {kBlock, 0.2f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     split_long_edges(part, goal, kLongest);
                     collapse_short_edges(part, kShortest, kLongest);
                     flip_to_valence(part, 3);
                     smooth(part, goal, 2);
                     if (round >= kRounds - kRepairedRounds) repair(part, goal, kSine20, 4);
                   });
  finish(backend, goal, surface);
  return make_mesh(surface);
}

std::vector<CarefulPlace> places_of(const TriangleMesh& mesh, std::span<const TrianglePair> pairs,
                                    float radius, float factor) {
  std::vector<CarefulPlace> places;
  for (const TrianglePair& pair : pairs) {
    Vec3 centre;
    for (std::uint32_t t : {pair.first, pair.second})
      for (int i = 0; i < 3; ++i) {
        const float* p = mesh.vertices.data() + 3 * std::size_t{mesh.triangles[3 * t + i]};
        centre = centre + (1.0f / 6) * Vec3{p[0], p[1], p[2]};
      }
    bool covered = false;
    for (const CarefulPlace& place : places)
      covered |= squared_norm(centre - place.centre) < 0.25f * radius * radius;
    if (!covered) places.push_back({centre, radius, factor});
  }
  return places;
}

ProvenSurface remesh_proven(Backend& backend, const FieldView& field, const SizeView& sizes,
                            const TriangleMesh& mesh) {
  struct Attempt {
    float radius, factor;
  };
  constexpr Attempt kAttempts[] = {{2, 0.6f}, {3, 0.4f}, {3, 0}, {5, 0}, {8, 0}};
  ProvenSurface result;
  std::vector<TrianglePair> pairs;
  result.mesh = remesh(backend, field, sizes, mesh);
  result.intersecting_pairs = count_pairs(backend, result.mesh, pairs);
  for (const Attempt& attempt : kAttempts) {
    if (result.intersecting_pairs == 0) return result;
    for (const CarefulPlace& place : places_of(result.mesh, pairs, attempt.radius, attempt.factor))
      result.places.push_back(place);
    result.mesh = remesh(backend, field, sizes, mesh, result.places);
    result.intersecting_pairs = count_pairs(backend, result.mesh, pairs);
  }
  return result;
}

}  // namespace vasamesh

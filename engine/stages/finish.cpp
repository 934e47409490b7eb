#include "stages/finish.h"

#include <algorithm>

#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr float kBlock = 32;  // voxel lengths
constexpr int kRounds = 3;
constexpr int kLastRounds = 4;  // that may follow where triangles with small angles are left

/// Whether a triangle has an angle below 20 degrees.
bool any_poor(const WorkingSurface& surface) {
  for (std::size_t c = 0; c < surface.triangles.size(); c += 3)
    if (triangle_quality(surface.points[surface.triangles[c]],
                         surface.points[surface.triangles[c + 1]],
                         surface.points[surface.triangles[c + 2]], -1) < kSine20)
      return true;
  return false;
}

}  // namespace

void finish(Backend& backend, const RemeshGoal& goal, WorkingSurface& surface) {
  for (int round = 0; round < kRounds; ++round)
    for_each_block(backend, {kBlock, 0.1f + 0.25f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     if (!goal.wants(part)) return;
                     flip_to_angle(part, 3);
                     smooth(part, goal, 2);
                     equalise(part, goal, 2);
                     if (round < kRounds - 1) {
                       repair(part, goal, kSine20, 2);
                       return;
                     }
                     repair(part, goal, kSine40, 3);
                     equalise(part, goal, 4);
                     repair(part, goal, kSine25, 24);
                   });
  for (int round = 0; round < kLastRounds && any_poor(surface); ++round)
    for_each_block(backend, {kBlock, 0.23f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     if (goal.wants(part)) repair(part, goal, kSine25, 16);
                   });
}

void fix_places(const RemeshGoal& goal, WorkingSurface& surface) {
  const bool any = std::any_of(goal.places.begin(), goal.places.end(),
                               [](const CarefulPlace& place) { return place.factor == 0; });
  if (!any) return;
  surface.fixed.resize(surface.points.size());
  for (std::size_t v = 0; v < surface.points.size(); ++v)
    surface.fixed[v] = goal.size_at(surface.points[v].position) == 0;
}

TriangleMesh finish(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh, std::span<const CarefulPlace> places) {
  const RemeshGoal goal = {field, sizes, places, !places.empty()};
  WorkingSurface surface = make_working_surface(backend, goal, mesh);
  fix_places(goal, surface);
  finish(backend, goal, surface);
  return make_mesh(surface);
}

}  // namespace vasamesh

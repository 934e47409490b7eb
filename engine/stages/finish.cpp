#include "stages/finish.h"

#include <vector>

#include "stages/patch_rules.h"
#include "stages/relax.h"

namespace vasamesh {

namespace {

constexpr int kRounds = 3;
constexpr int kFitRounds = 2;
constexpr int kLastRounds = 4;  // that may follow where triangles with small angles are left

/// Whether a triangle of the part has an angle below 20 degrees.
bool any_poor(const PatchMesh& part) {
  for (std::uint32_t h = 0; h < part.half_edge_end(); h += 4)
    if (part.is_edge(h) && least_squared_sine(part, h) < kSquaredSine20) return true;
  return false;
}

bool any_poor(const Backend& backend, const WorkingSurface& surface) {
  constexpr std::size_t kAsked = 3 << 16;  // corners between two checkpoints
  for (std::size_t c = 0; c < surface.triangles.size(); c += 3) {
    if (c % kAsked == 0) backend.checkpoint();
    if (least_squared_sine(surface.points[surface.triangles[c]],
                           surface.points[surface.triangles[c + 1]],
                           surface.points[surface.triangles[c + 2]]) < kSquaredSine20)
      return true;
  }
  return false;
}

}  // namespace

void finish(Backend& backend, const RemeshGoal& goal, WorkingSurface& surface) {
  Relaxer relaxer(backend, goal);
  const float side = block_side(goal.sizes);
  const auto repair_all = [&](std::span<PatchMesh* const> parts, float wanted, int passes) {
    for_each_part(backend, parts, [&](PatchMesh& part) { repair(part, goal, wanted, passes); });
  };
  for (int round = 0; round < kRounds; ++round) {
    SurfaceBlocks blocks(backend, {side, 0.1f + 0.25f * static_cast<float>(round)}, surface);
    const std::vector<PatchMesh*> parts = blocks.parts();
    const bool is_last = round == kRounds - 1;
    for_each_part(backend, parts, [](PatchMesh& part) { flip_to_valence(part, 3); });
    relaxer.smooth(parts, 1);
    repair_all(parts, kSquaredSine40, 1);
    relaxer.equalise(parts, is_last ? 4 : 2);
    if (is_last) repair_all(parts, kSquaredSine25, 24);
    blocks.join();
  }
  for (int round = 0; round < kLastRounds && any_poor(backend, surface); ++round) {
    SurfaceBlocks blocks(backend, {side, 0.23f * static_cast<float>(round)}, surface);
    std::vector<PatchMesh*> parts = blocks.parts();
    std::erase_if(parts, [](const PatchMesh* part) { return !any_poor(*part); });
    for_each_part(backend, parts, [](PatchMesh& part) { flip_to_angle(part, 3); });
    relaxer.smooth(parts, 1);
    relaxer.equalise(parts, 8);
    repair_all(parts, kSquaredSine25, 24);
    blocks.join();
  }
  for (int round = 0; round < kFitRounds; ++round) {
    SurfaceBlocks blocks(backend, {side, 0.1f + 0.4f * static_cast<float>(round)}, surface);
    const std::vector<PatchMesh*> parts = blocks.parts();
    relaxer.fit(parts, 4);
    blocks.join();
  }
}

TriangleMesh finish(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh, std::span<const CarefulPlace> places) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful, !places.empty()};
  WorkingSurface surface = make_working_surface(backend, goal, mesh);
  fix_places(backend, goal, surface);
  finish(backend, goal, surface);
  return make_mesh(backend, surface);
}

}  // namespace vasamesh

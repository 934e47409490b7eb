#include "stages/remesh.h"

#include <algorithm>
#include <utility>

#include "stages/finish.h"
#include "stages/patch_blocks.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"
#include "stages/relax.h"

namespace vasamesh {

namespace {

constexpr float kFineBlock = 16;  // voxel lengths
constexpr int kRounds = 5;
constexpr int kPlaceRounds = 2;
constexpr int kRepairedRounds = 2;  // the last ones

/// A vertex removed is one that the next rounds need not look at: from the shortest edges up.
constexpr float kCoarsening[] = {0.3f, 0.5f, 0.7f, kShortest};

/// Rounds of split, collapse, flip and smooth; the last `repaired` of them repair as well.
void run_rounds(Backend& backend, const RemeshGoal& goal, int rounds, int repaired,
                WorkingSurface& surface) {
  Relaxer relaxer(backend, goal);
  for (int round = 0; round < rounds; ++round) {
    SurfaceBlocks blocks(backend, {block_side(goal.sizes), 0.2f * static_cast<float>(round)},
                         surface);
    const std::vector<PatchMesh*> parts = blocks.parts();
    for_each_part(backend, parts, [&](PatchMesh& part) {
      split_long_edges(part, goal, kLongest);
      collapse_short_edges(part, kShortest, kLongest);
      flip_to_valence(part, 3);
    });
    relaxer.smooth(parts, 2);
    if (round >= rounds - repaired)
      for_each_part(backend, parts,
                    [&](PatchMesh& part) { repair(part, goal, kSquaredSine20, 4); });
    blocks.join();
  }
}

/// The surface from its base, as far as the places allow.
WorkingSurface remesh_base(Backend& backend, const RemeshGoal& goal, const TriangleMesh& mesh) {
  WorkingSurface surface = make_working_surface(backend, goal, mesh);
  fix_places(backend, goal, surface);
  for_each_block(backend, {kFineBlock, 0.5f}, surface, [&](PatchMesh& part) {
    for (float shortest : kCoarsening) collapse_short_edges(part, shortest, kLongest);
  });
  run_rounds(backend, goal, kRounds, kRepairedRounds, surface);
  return surface;
}

}  // namespace

TriangleMesh remesh(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh, std::span<const CarefulPlace> places) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful, false};
  WorkingSurface surface = remesh_base(backend, goal, mesh);
  finish(backend, goal, surface);
  return make_mesh(backend, surface);
}

TriangleMesh remesh_patches(Backend& backend, const FieldView& field, const SizeView& sizes,
                            const TriangleMesh& mesh, std::span<const CarefulPlace> places) {
  const Places careful(places);
  return make_mesh(backend, remesh_base(backend, {field, sizes, &careful, false}, mesh));
}

TriangleMesh remesh_places(Backend& backend, const FieldView& field, const SizeView& sizes,
                           const TriangleMesh& mesh, std::span<const CarefulPlace> places) {
  const Places careful(places);
  const RemeshGoal goal = {field, sizes, &careful, true};
  WorkingSurface surface = make_working_surface(backend, goal, mesh);
  run_rounds(backend, goal, kPlaceRounds, kRepairedRounds, surface);
  finish(backend, goal, surface);
  return make_mesh(backend, surface);
}

}  // namespace vasamesh

#include "stages/remesh.h"

#include "stages/patch_blocks.h"
#include "stages/patch_passes.h"
#include "stages/patch_rules.h"

namespace vasamesh {

namespace {

constexpr int kRounds = 5, kFinishRounds = 4;
constexpr float kFineBlock = 16, kBlock = 32;  // voxel lengths

}  // namespace

TriangleMesh remesh(Backend& backend, const FieldView& field, const SizeView& sizes,
                    const TriangleMesh& mesh) {
  const RemeshGoal goal = {field, sizes};
  WorkingSurface surface = make_working_surface(backend, field, sizes, mesh);
  for_each_block(backend, {kFineBlock, 0.5f}, surface, [](PatchMesh& part) {
    for (float shortest : {0.3f, 0.5f, 0.7f, kShortest})
      collapse_short_edges(part, shortest, kLongest);
  });
  for (int round = 0; round < kRounds; ++round)
    for_each_block(backend, {kBlock, 0.2f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     split_long_edges(part, goal, kLongest);
                     collapse_short_edges(part, kShortest, kLongest);
                     flip_to_valence(part, 3);
                     smooth(part, goal, 2);
                   });
  for (int round = 0; round < kFinishRounds; ++round)
    for_each_block(backend, {kBlock, 0.1f + 0.25f * static_cast<float>(round)}, surface,
                   [&](PatchMesh& part) {
                     flip_to_angle(part, 3);
                     smooth(part, goal, 2);
                     equalise(part, goal, 2);
                     repair(part, goal, kSine25, round == kFinishRounds - 1 ? 32 : 4);
                   });
  return make_mesh(surface);
}

}  // namespace vasamesh

#include "stages/expand.h"

#include "stages/expand_front.h"
#include "stages/expand_patches.h"
#include "stages/expand_rounds.h"
#include "stages/expand_seeds.h"

namespace vasamesh {

namespace {

constexpr int kMostWaves = 8;  // of seeds
constexpr double kBudget = 3;  // times the predicted triangles
constexpr std::size_t kLeastBudget = 1000;

/// Of the last rounds: what is left may be closed by less regular triangles.
constexpr FrontLimits kLastLimits = {
    .join_reach = 1.3f, .least_tau = 0.3f, .least_angle = 0.35f, .off_surface = 0.28f};

}  // namespace

FrontResult expand(Backend& backend, const IndicatorField& field, const SizeField& sizes,
                   const TriangleMesh& patches) {
  const FieldView view = field.view();
  const SizeView size_view = sizes.view(field);
  Front front = take_patches(backend, view, size_view, patches);
  const auto most = static_cast<std::size_t>(kBudget * sizes.predicted_triangles) + kLeastBudget +
                    patches.triangle_count();
  const auto expected = static_cast<std::size_t>(sizes.predicted_triangles);
  front.reserve(expected / 2, expected, expected / 2);
  FrontRounds rounds(backend, view, size_view, front, most);

  FrontSeeds seeds(view, size_view, sizes.samples);
  bool in_budget = true;
  for (int wave = 0; wave < kMostWaves && in_budget; ++wave) {
    if (seeds.add(backend, front) == 0 && wave > 0) break;
    in_budget = rounds.run({});
  }
  if (in_budget) in_budget = rounds.run(kLastLimits, true);

  FrontResult result = give_result(front);
  result.rounds = rounds.count();
  result.over_budget = !in_budget;
  return result;
}

}  // namespace vasamesh

#include "stages/expand.h"

#include "stages/expand_front.h"
#include "stages/expand_patches.h"
#include "stages/expand_rounds.h"
#include "stages/expand_seeds.h"

namespace vasamesh {

FrontResult expand(Backend& backend, const IndicatorField& field, const SizeField& sizes,
                   const TriangleMesh& patches) {
  constexpr int kMostWaves = 8;
  constexpr double kBudget = 3;  // times the predicted triangles
  const FieldView view = field.view();
  const SizeView size_view = sizes.view(field);
  Front front = take_patches(backend, view, size_view, patches);
  const auto most = static_cast<std::size_t>(kBudget * sizes.predicted_triangles) + 1000 +
                    patches.triangle_count();
  FrontRounds rounds(backend, view, size_view, front, most);

  bool in_budget = true;
  for (int wave = 0; wave < kMostWaves && in_budget; ++wave) {
    if (add_seeds(backend, view, size_view, sizes.samples, front) == 0 && wave > 0) break;
    in_budget = rounds.run({});
  }
  // What is left may be closed by less regular triangles.
  for (const std::uint32_t corner : front.alive) front.state[corner] = kChanged;
  if (in_budget) in_budget = rounds.run({1.3f, 0.3f, 0.35f, 0.28f});

  FrontResult result = give_result(front);
  result.rounds = rounds.count();
  result.over_budget = !in_budget;
  return result;
}

}  // namespace vasamesh

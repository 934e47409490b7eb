/// \file
/// Phantoms drawn voxel by voxel: the edge cases.

#include "phantom/random.h"
#include "phantom/recipe.h"

namespace vasamesh::phantom {
namespace {

constexpr int kSpecks = 10000;
constexpr int kSpeckPitch = 3;  ///< a speck fills at most 2 x 2 x 2 of 3 x 3 x 3 voxels

Recipe empty_recipe(const PhantomOptions& options, const Index3& size, const Topology& topology) {
  Recipe recipe;
  const Ruler ruler(options, 1, {0.8, 0.8, 0.8});
  recipe.lattice = {size, Vec3::Zero(), ruler.spacing};
  recipe.drawn.assign(static_cast<std::size_t>(size[0]) * size[1] * size[2], 0);
  recipe.topology = topology;
  return recipe;
}

std::uint8_t& voxel(Recipe& recipe, int i, int j, int k) {
  const Index3& size = recipe.lattice.size;
  return recipe.drawn[(static_cast<std::size_t>(size[1]) * k + j) * size[0] + i];
}

Index3 size_or(const PhantomOptions& options, const Index3& size) {
  if (!options.size) return size;
  const auto& s = *options.size;
  return {static_cast<int>(s[0]), static_cast<int>(s[1]), static_cast<int>(s[2])};
}

/// Any voxels of a 2 x 2 x 2 block, but not none and not all.
void draw_speck(Recipe& recipe, int i, int j, int k, int bits) {
  for (int corner = 0; corner < 8; ++corner)
    if (bits >> corner & 1)
      voxel(recipe, i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)) = 1;
}

}  // namespace

Recipe single_voxel_recipe(const PhantomOptions& options) {
  Recipe recipe = empty_recipe(options, {7, 5, 6}, {1, 0, 0});
  voxel(recipe, 3, 2, 4) = 1;
  return recipe;
}

Recipe voxel_line_recipe(const PhantomOptions& options) {
  Recipe recipe = empty_recipe(options, {23, 5, 5}, {1, 0, 0});
  for (int i = 3; i < 20; ++i) voxel(recipe, i, 2, 2) = 1;
  return recipe;
}

Recipe one_slice_recipe(const PhantomOptions& options) {
  Recipe recipe = empty_recipe(options, {41, 33, 1}, {1, 1, 0});
  for (int j = 0; j < 33; ++j)
    for (int i = 0; i < 41; ++i) {
      const int square = (i - 19) * (i - 19) + (j - 16) * (j - 16);
      voxel(recipe, i, j, 0) = square <= 150 && square >= 40;
    }
  return recipe;
}

Recipe full_box_recipe(const PhantomOptions& options) {
  Recipe recipe = empty_recipe(options, size_or(options, {21, 17, 13}), {1, 0, 0});
  std::fill(recipe.drawn.begin(), recipe.drawn.end(), std::uint8_t{1});
  return recipe;
}

Recipe speckle_recipe(const PhantomOptions& options) {
  Recipe recipe = empty_recipe(options, size_or(options, {70, 67, 66}), {});
  const Index3& size = recipe.lattice.size;
  Random random(options.seed);
  Topology& topology = *recipe.topology;
  for (int k = 1; k + kSpeckPitch <= size[2]; k += kSpeckPitch)
    for (int j = 1; j + kSpeckPitch <= size[1]; j += kSpeckPitch)
      for (int i = 1; i + kSpeckPitch <= size[0] && topology.pieces < kSpecks; i += kSpeckPitch) {
        draw_speck(recipe, i, j, k, 1 + random.below(254));
        ++topology.pieces;
      }
  return recipe;
}

}  // namespace vasamesh::phantom

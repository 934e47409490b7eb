/// \file
/// Phantoms that are vessel trees: small ones by seed, and the three data sets of the paper's
/// Table 1 by size, spacing and number of marching-cubes triangles.

#include <cmath>
#include <limits>
#include <utility>

#include "phantom/random.h"
#include "phantom/recipe.h"
#include "phantom/tree.h"
#include "vasamesh/errors.h"

namespace vasamesh::phantom {
namespace {

constexpr double kTreeStep = 0.33;

/// The recipe's frame is centred on the lattice.
VoxelGrid centred_lattice(const Index3& size, const Vec3& spacing) {
  VoxelGrid lattice{size, Vec3::Zero(), spacing};
  for (int a = 0; a < 3; ++a) lattice.start[a] = -0.5 * (size[a] - 1) * spacing[a];
  return lattice;
}

/// Where a vessel that thick stays inside the lattice, however it is bent.
Vec3 half_room(const TreePlan& plan, const VoxelGrid& lattice, double radius) {
  return -lattice.start - Vec3::Constant(kLargestBend * plan.bending + radius);
}

Recipe tree_recipe_of(TreePlan plan, const VoxelGrid& lattice) {
  const Vec3 half = half_room(plan, lattice, 0);
  plan.room = {-half, half};
  Recipe recipe;
  recipe.lattice = lattice;
  recipe.exact_step = kTreeStep;
  recipe.least_radius = plan.end_radius;
  for (const Vessel& vessel : grow_tree(plan)) {
    append_tube(recipe.solid.parts, vessel.points, vessel.radius);
    recipe.lines.push_back(vessel.points);
  }
  return recipe;
}

Vessel trunk(std::vector<Vec3> points, double first_radius, double last_radius) {
  Vessel vessel;
  vessel.points = std::move(points);
  const double last = static_cast<double>(vessel.points.size()) - 1;
  for (double i = 0; i <= last; ++i)
    vessel.radius.push_back(first_radius + (last_radius - first_radius) * i / last);
  return vessel;
}

/// A saccular aneurysm of that radius on the side of the vessel nearest to `place`.
void add_aneurysm(Recipe& recipe, const Vec3& place, const Vec3& way, double radius) {
  Vec3 neck = place;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& line : recipe.lines)
    for (const Vec3& p : line)
      if ((p - place).squaredNorm() < least) least = (p - place).squaredNorm(), neck = p;
  const Vec3 dome = neck + 1.35 * radius * way.normalized();
  recipe.solid.parts.emplace_back(RoundCone(neck, dome, 0.5 * radius, radius));
}

Vec3 tree_spacing(Random& random) {
  static const Vec3 choices[] = {{0.6, 0.6, 0.6}, {0.5, 0.5, 0.8}, {0.8, 0.7, 0.7}, {1, 1, 0.6}};
  return choices[random.below(4)];
}

}  // namespace

Recipe tree_recipe(const PhantomOptions& options) {
  Random random(options.seed);
  const Ruler ruler(options, 0.8, tree_spacing(random));
  Index3 size;
  for (int a = 0; a < 3; ++a)
    size[a] = options.size ? static_cast<int>((*options.size)[a]) : 52 + random.below(37);
  const VoxelGrid lattice = centred_lattice(size, ruler.spacing);
  const double v = ruler.voxel;
  TreePlan plan;
  plan.seed = random.next();
  plan.step = 2 * v;
  plan.tip_radius = ruler.radius;
  plan.end_radius = 0.6 * ruler.radius;
  plan.bending = 1.6 * v;
  plan.bending_length = 30 * v;
  const Vec3 half = half_room(plan, lattice, ruler.radius + v);
  if (half.minCoeff() < 2 * v)
    throw Error(ErrorCode::usage,
                "phantom 'tree': the vessels do not fit; give a larger size or a smaller radius");
  const bool cut = random.below(2) == 1;  // whether the root is cut by the border
  const double root = lattice.start[2] - (cut ? 3 * v : -5 * v);
  plan.trunks = {trunk({{0, 0, root}, {0, 0, -0.6 * half[2]}}, ruler.radius, ruler.radius)};
  plan.regions = {{Vec3::Zero(), half, 0, 12 + random.below(14)}};
  return tree_recipe_of(plan, lattice);
}

Recipe cerebral_recipe(const PhantomOptions& options) {
  const VoxelGrid lattice = centred_lattice({512, 512, 170}, {0.51, 0.51, 0.80});
  TreePlan plan;
  plan.seed = options.seed;
  plan.tip_radius = 0.52;
  plan.bare_radius = 2;
  plan.end_radius = 0.3;
  // Two carotid arteries and the basilar artery, cut by the lower border, and the circle of Willis.
  const Vec3 right(-14, -8, -42), left(14, -8, -42), front(0, -26, -36), back(0, 18, -42);
  plan.trunks = {trunk({{-24, 4, -74}, {-22, 6, -60}, {-14, -2, -54}, right}, 3.8, 2.5),
                 trunk({{24, 4, -74}, {22, 6, -60}, {14, -2, -54}, left}, 3.8, 2.5),
                 trunk({{1, 30, -74}, {-1, 26, -58}, back}, 3.0, 2.1),
                 trunk({right, {-8, -20, -38}, front}, 1.6, 1.2),
                 trunk({left, {8, -20, -38}, front}, 1.6, 1.2),
                 trunk({right, {-12, 6, -43}, back}, 1.0, 1.4),
                 trunk({left, {12, 6, -43}, back}, 1.0, 1.4)};
  plan.regions = {{{0, 0, -1}, {96, 106, 59}, 0.35, 66}};
  Recipe recipe = tree_recipe_of(plan, lattice);
  add_aneurysm(recipe, right, {-0.6, -0.7, 0.4}, 4);
  return recipe;
}

Recipe liver_recipe(const PhantomOptions& options) {
  const VoxelGrid lattice = centred_lattice({512, 512, 279}, {0.6563, 0.6563, 0.5});
  TreePlan plan;
  plan.seed = options.seed;
  plan.tip_radius = 0.7;
  plan.end_radius = 0.4;
  plan.bare_radius = 4.8;
  plan.step = 2;
  plan.trunks = {trunk({{70, -20, -80}, {66, -10, -50}, {50, 0, -20}, {25, 5, 0}}, 6.5, 4.5)};
  plan.regions = {{{-10, 0, 0}, {145, 130, 60}, 0, 125}};
  return tree_recipe_of(plan, lattice);
}

Recipe aorta_recipe(const PhantomOptions& options) {
  const VoxelGrid lattice = centred_lattice({512, 512, 167}, {0.961, 0.961, 1.80});
  TreePlan plan;
  plan.seed = options.seed;
  plan.tip_radius = 0.9;
  plan.end_radius = 0.6;
  plan.step = 3;
  plan.bending = 4;
  plan.bending_length = 80;
  plan.trunks = {trunk({{0, 20, 160}, {0, 24, 60}, {4, 20, -40}, {0, 10, -70}}, 11, 8),
                 trunk({{0, 10, -70}, {-25, 10, -110}, {-45, -20, -160}}, 6, 5),
                 trunk({{0, 10, -70}, {25, 10, -110}, {45, -20, -160}}, 6, 5)};
  plan.regions = {{{0, -40, 30}, {160, 130, 100}, 0.2, 110}};
  return tree_recipe_of(plan, lattice);
}

}  // namespace vasamesh::phantom

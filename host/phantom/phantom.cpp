#include "phantom/phantom.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "phantom/recipe.h"
#include "phantom/surface.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using namespace phantom;

/// Which options mean something for a phantom, beside `seed` and `exact`.
enum Takes : unsigned { kSize = 1, kSpacing = 2, kRadius = 4 };

struct Entry {
  const char* name;
  const char* summary;
  unsigned takes;
  Recipe (*make)(const PhantomOptions&);
};

constexpr Entry kEntries[] = {
    {"sphere", "a ball", kSpacing | kRadius, sphere_recipe},
    {"torus", "a tilted ring", kSpacing | kRadius, torus_recipe},
    {"helix", "two turns of a coil", kSpacing | kRadius, helix_recipe},
    {"y_branch", "a bifurcation by Murray's law", kSpacing | kRadius, y_branch_recipe},
    {"aneurysm", "a bent tube with a berry on it", kSpacing | kRadius, aneurysm_recipe},
    {"two_tubes", "two tubes one voxel apart", kSpacing | kRadius, two_tubes_recipe},
    {"line_axis", "a one-voxel line along an axis on a trunk", kSpacing | kRadius,
     line_axis_recipe},
    {"line_face_diagonal", "a one-voxel line along a face diagonal on a trunk", kSpacing | kRadius,
     line_face_diagonal_recipe},
    {"line_space_diagonal", "a one-voxel line along a space diagonal on a trunk",
     kSpacing | kRadius, line_space_diagonal_recipe},
    {"cut_tube", "a slanting tube cut by the volume's border", kSpacing | kRadius, cut_tube_recipe},
    {"hollow_shell", "a ball with a cavity", kSpacing | kRadius, hollow_shell_recipe},
    {"anisotropic_arch", "an arch, spacing ratio 2", kSpacing | kRadius, anisotropic_arch_recipe},
    {"single_voxel", "one voxel", kSpacing, single_voxel_recipe},
    {"voxel_line", "a line of voxels", kSpacing, voxel_line_recipe},
    {"one_slice", "a ring in a volume of one slice", kSpacing, one_slice_recipe},
    {"full_box", "foreground that fills the volume", kSize | kSpacing, full_box_recipe},
    {"speckle", "10,000 specks of one to seven voxels", kSize | kSpacing, speckle_recipe},
    {"tree", "a small random vessel tree", kSize | kSpacing | kRadius, tree_recipe},
    {"cerebral", "a cerebral tree, 512 x 512 x 170 voxels", 0, cerebral_recipe},
    {"liver", "a portal tree, 512 x 512 x 279 voxels", 0, liver_recipe},
    {"aorta", "an aortic tree, 512 x 512 x 167 voxels", 0, aorta_recipe},
};

const Entry& find_entry(std::string_view name) {
  for (const Entry& entry : kEntries)
    if (entry.name == name) return entry;
  throw Error(ErrorCode::usage, fmt::format("phantom '{}': no such phantom; there are {}", name,
                                            fmt::join(phantom_names(), ", ")));
}

void refuse_option(const Entry& entry, const char* option, bool given, unsigned takes) {
  if (given && !(entry.takes & takes))
    throw Error(ErrorCode::usage,
                fmt::format("phantom '{}': {} is fixed; leave it out", entry.name, option));
}

void require_range(const Entry& entry, const char* option, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw Error(ErrorCode::usage, fmt::format("phantom '{}': {} is {}; give one from {} to {}",
                                              entry.name, option, value, low, high));
}

void validate_options(const Entry& entry, const PhantomOptions& options) {
  refuse_option(entry, "the size", options.size.has_value(), kSize);
  refuse_option(entry, "the spacing", options.spacing.has_value(), kSpacing);
  refuse_option(entry, "the radius", options.radius.has_value(), kRadius);
  for (int a = 0; a < 3; ++a) {
    if (options.size)
      require_range(entry, "the size", static_cast<double>((*options.size)[a]), 24, 1024);
    if (options.spacing) require_range(entry, "the spacing", (*options.spacing)[a], 0.01, 100);
  }
  if (options.spacing) {
    const auto [least, largest] =
        std::minmax_element(options.spacing->begin(), options.spacing->end());
    require_range(entry, "the ratio of the spacings", *largest / *least, 1, 20);
  }
  if (options.radius) require_range(entry, "the radius", *options.radius, 0.5, 32);
  if (options.exact_step != 0) require_range(entry, "the exact step", options.exact_step, 0.1, 1);
}

Geometry centred_geometry(const VoxelGrid& lattice) {
  Geometry geometry;
  for (int a = 0; a < 3; ++a) {
    geometry.size[a] = lattice.size[a];
    geometry.spacing[a] = lattice.step[a];
    geometry.origin[a] = -0.5 * (lattice.size[a] - 1) * lattice.step[a];
  }
  return geometry;
}

std::vector<std::uint8_t> voxels_of(const Recipe& recipe) {
  const VoxelGrid& lattice = recipe.lattice;
  std::vector<std::uint8_t> voxels = recipe.drawn;
  voxels.resize(static_cast<std::size_t>(lattice.size[0]) * lattice.size[1] * lattice.size[2]);
  if (!recipe.solid.parts.empty()) voxelise(recipe.solid, lattice, voxels);
  for (const auto& line : recipe.lines) draw_line(line, lattice, voxels);
  return voxels;
}

TriangleMesh surface_of(const Recipe& recipe, const Geometry& geometry, double exact_step) {
  const VoxelGrid& lattice = recipe.lattice;
  const Eigen::AlignedBox3d border(
      lattice.node(0, 0, 0) - 0.5 * lattice.step,
      lattice.node(lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1) +
          0.5 * lattice.step);
  const double step = exact_step > 0 ? exact_step : recipe.exact_step;
  const phantom::Vec3 shift = phantom::Vec3(geometry.origin.data()) - lattice.start;
  return exact_surface(recipe.solid, border, step * lattice.step.minCoeff(), shift);
}

}  // namespace

std::vector<std::string> phantom_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kEntries) names.emplace_back(entry.name);
  return names;
}

std::string phantom_summary(std::string_view name) { return find_entry(name).summary; }

Phantom make_phantom(std::string_view name, const PhantomOptions& options) {
  const Entry& entry = find_entry(name);
  validate_options(entry, options);
  const Recipe recipe = entry.make(options);
  Phantom phantom;
  phantom.name = entry.name;
  phantom.geometry = centred_geometry(recipe.lattice);
  phantom.voxels = voxels_of(recipe);
  phantom.has_exact = recipe.exact_step > 0;
  phantom.least_radius = recipe.least_radius / std::cbrt(recipe.lattice.step.prod());
  phantom.topology = recipe.topology;
  if (options.exact && phantom.has_exact)
    phantom.exact = surface_of(recipe, phantom.geometry, options.exact_step);
  return phantom;
}

}  // namespace vasamesh

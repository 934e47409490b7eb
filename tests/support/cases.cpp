#include "support/cases.h"

#include <algorithm>

namespace vasamesh {
namespace {

constexpr const char* kLarge[] = {"cerebral", "liver", "aorta"};
constexpr double kAccurateRadius = 2.5;  ///< voxels

bool is_large(const std::string& name) {
  return std::find(std::begin(kLarge), std::end(kLarge), name) != std::end(kLarge);
}

PhantomCase with_spacing(const std::string& name, const std::array<double, 3>& spacing,
                         const std::string& suffix) {
  PhantomCase found{name + suffix, name, {}};
  found.options.spacing = spacing;
  return found;
}

PhantomCase with_radius(const std::string& name, double radius, const std::string& suffix) {
  PhantomCase found{name + suffix, name, {}};
  found.options.radius = radius;
  return found;
}

}  // namespace

std::vector<PhantomCase> small_cases() {
  std::vector<PhantomCase> cases;
  for (const std::string& name : phantom_names())
    if (!is_large(name)) cases.push_back({name, name, {}});
  return cases;
}

std::vector<PhantomCase> tree_cases(int count) {
  std::vector<PhantomCase> cases;
  for (int seed = 1; seed <= count; ++seed) {
    cases.push_back({"tree_" + std::to_string(seed), "tree", {}});
    cases.back().options.seed = static_cast<std::uint64_t>(seed);
  }
  return cases;
}

std::vector<PhantomCase> large_cases() {
  std::vector<PhantomCase> cases;
  for (const char* name : kLarge) cases.push_back({name, name, {}});
  return cases;
}

std::vector<PhantomCase> accuracy_cases() {
  std::vector<PhantomCase> cases;
  for (const PhantomCase& candidate : small_cases()) {
    const Phantom phantom = candidate.make();
    if (phantom.has_exact && phantom.least_radius >= kAccurateRadius) cases.push_back(candidate);
  }
  cases.push_back(with_spacing("y_branch", {0.51, 0.51, 0.8}, "_cerebral_spacing"));
  cases.push_back(with_spacing("helix", {0.6563, 0.6563, 0.5}, "_liver_spacing"));
  cases.push_back(with_spacing("torus", {0.961, 0.961, 1.8}, "_aorta_spacing"));
  cases.push_back(with_radius("helix", 2.5, "_thin"));
  cases.push_back(with_radius("aneurysm", 2.5, "_thin"));
  cases.push_back(with_radius("y_branch", 7, "_thick"));
  return cases;
}

}  // namespace vasamesh

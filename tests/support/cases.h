#pragma once

/// \file
/// Case descriptors: the inputs that tests and benchmarks share.

#include <cstdint>
#include <string>
#include <vector>

#include "phantom/phantom.h"

namespace vasamesh {

/// One input by name and options; `make()` builds it. `label` is unique and fit for a test's name.
struct PhantomCase {
  std::string label;
  std::string name;
  PhantomOptions options;

  Phantom make() const { return make_phantom(name, options); }
};

/// Every phantom but the three of the paper's sizes.
std::vector<PhantomCase> small_cases();

/// `count` random trees by the fixed seeds 1 .. count, of sizes and spacings that vary by seed.
std::vector<PhantomCase> tree_cases(int count);

/// The paper's three data sets: cerebral, liver, aorta.
std::vector<PhantomCase> large_cases();

/// Phantoms with an exact surface and radii of 2.5 voxels or more: the accuracy figures' inputs.
std::vector<PhantomCase> accuracy_cases();

}  // namespace vasamesh

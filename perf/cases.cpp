/// \file
/// vasamesh_cases [TREES]: the phantoms that the figures are measured on, those of the tests, and
/// TREES random trees (100). One line each, separated by tabs: label, kind ("small", "accuracy",
/// "tree", "large"), whether an exact surface exists (0 or 1), whether the limits of accuracy hold
/// for it (0 or 1: no radius below 2.5 voxels), and the arguments of `vasamesh phantom`.

#include "support/cases.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <set>

namespace {

using vasamesh::PhantomCase;

std::string arguments(const PhantomCase& input) {
  std::string text = input.name;
  if (input.options.seed != 1) text += fmt::format(" --seed {}", input.options.seed);
  if (input.options.spacing)
    text += fmt::format(" --spacing {}", fmt::join(*input.options.spacing, " "));
  if (input.options.radius) text += fmt::format(" --radius {}", *input.options.radius);
  return text;
}

void print(const PhantomCase& input, const char* kind, bool exact, bool accurate) {
  fmt::print("{}\t{}\t{:d}\t{:d}\t{}\n", input.label, kind, exact, accurate, arguments(input));
}

}  // namespace

int main(int argc, char** argv) {
  std::set<std::string> accurate;
  for (const PhantomCase& input : vasamesh::accuracy_cases()) accurate.insert(input.label);
  std::set<std::string> printed;
  for (const PhantomCase& input : vasamesh::small_cases()) {
    print(input, "small", input.make().has_exact, accurate.count(input.label) > 0);
    printed.insert(input.label);
  }
  for (const PhantomCase& input : vasamesh::accuracy_cases())
    if (printed.count(input.label) == 0) print(input, "accuracy", true, true);
  const int trees = argc > 1 ? std::atoi(argv[1]) : 100;
  for (const PhantomCase& input : vasamesh::tree_cases(trees)) print(input, "tree", true, false);
  for (const PhantomCase& input : vasamesh::large_cases()) print(input, "large", true, false);
}

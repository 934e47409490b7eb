#include "io/length_unit.h"

#include <map>

#include "io/io_error.h"
#include "lower_case.h"

namespace vasamesh {
namespace {

/// A unit's name as kUnits has it: without the plural, in American spelling.
std::string unit_name(const std::string& name) {
  std::string unit = lower_case(name);
  if (const std::size_t metre = unit.find("metre"); metre != std::string::npos)
    unit.replace(metre, 5, "meter");
  if (unit.ends_with("meters") || unit.ends_with("microns")) unit.pop_back();
  return unit;
}

}  // namespace

double unit_in_mm(const std::string& path, const std::string& name, const char* field) {
  // The sign of micro is U+00B5, U+03BC or Latin-1's.
  static const std::map<std::string, double> kUnits = {{"", 1},
                                                       {"nm", 1e-6},
                                                       {"nanometer", 1e-6},
                                                       {"um", 1e-3},
                                                       {"\xc2\xb5m", 1e-3},
                                                       {"\xce\xbcm", 1e-3},
                                                       {"\xb5m", 1e-3},
                                                       {"micron", 1e-3},
                                                       {"micrometer", 1e-3},
                                                       {"mm", 1},
                                                       {"millimeter", 1},
                                                       {"cm", 10},
                                                       {"centimeter", 10},
                                                       {"m", 1e3},
                                                       {"meter", 1e3}};
  const auto unit = kUnits.find(unit_name(name));
  if (unit != kUnits.end()) return unit->second;
  throw_bad_input(path, "its unit of length is \"" + name + "\"",
                  std::string("give nm, um, mm, cm or m as the ") + field + " in its header");
}

void take_lengths_in(double unit, Geometry& geometry) {
  for (double& spacing : geometry.spacing) spacing *= unit;
  for (double& origin : geometry.origin) origin *= unit;
}

}  // namespace vasamesh

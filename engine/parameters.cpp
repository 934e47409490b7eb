#include "vasamesh/parameters.h"

#include <cmath>
#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

[[noreturn]] void out_of_range(const char* field, const std::string& range) {
  throw Error(ErrorCode::usage, std::string(field) + " is out of its range: give " + range);
}

}  // namespace

void validate(const Parameters& p) {
  if (p.neighbours < 3 || p.neighbours > 64) out_of_range("neighbours", "3 to 64");
  if (p.depth < 0 || p.depth > 24) out_of_range("depth", "0 (automatic) to 24");
  if (!std::isfinite(p.kernel_width) || p.kernel_width < 0.5 || p.kernel_width > 4)
    out_of_range("kernel width", "0.5 to 4 voxels");
  if (p.min_component < 0) out_of_range("min component", "0 (keep all) or more voxels");
  if (p.max_memory < 0) out_of_range("max memory", "0 (no limit) or more bytes");
  const int c = static_cast<int>(p.connectivity);
  if (c != 6 && c != 18 && c != 26) out_of_range("connectivity", "6, 18 or 26");
}

}  // namespace vasamesh

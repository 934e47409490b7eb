#include "io/memory_limit.h"

#include <fmt/format.h>
#include <unistd.h>

#include "io/io_error.h"

namespace vasamesh {
namespace {

std::int64_t machine_memory() {
  return static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
}

}  // namespace

void check_memory(const std::string& path, std::int64_t bytes, const ReadOptions& options) {
  const std::int64_t limit = options.max_memory > 0 ? options.max_memory : machine_memory();
  if (bytes <= limit) return;
  throw_refused(
      path, fmt::format("it needs {} bytes of memory, {} are allowed", bytes, limit),
      options.max_memory > 0 ? "raise --max-memory or crop the volume" : "crop the volume");
}

}  // namespace vasamesh

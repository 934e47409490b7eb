#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "cli/program.h"

namespace {

/// Keeps what is freed for the blocks that are asked for next, and most are: given back to the
/// system, large ones would be had page by page, each cleared anew.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kKept = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, kKept);
  mallopt(M_TRIM_THRESHOLD, kKept);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  return vasamesh::cli::run(argc, argv);
}

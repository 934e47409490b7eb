#include "vasamesh/version.h"

namespace vasamesh {

const char* version() { return VASAMESH_VERSION; }

}  // namespace vasamesh

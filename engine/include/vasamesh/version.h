#pragma once

namespace vasamesh {

/// The library's version, "major.minor.patch" (semantic versioning).
const char* version();

}  // namespace vasamesh

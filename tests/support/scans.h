#pragma once

/// \file
/// Where real scans are.

#include <cstdlib>
#include <optional>
#include <string>

namespace vasamesh::test {

/// The path of a file among the real scans; none where VASAMESH_TEST_DATA is not set, or empty.
inline std::optional<std::string> scan_path(const std::string& file) {
  const char* folder = std::getenv("VASAMESH_TEST_DATA");
  if (!folder || !*folder) return std::nullopt;
  return std::string(folder) + "/" + file;
}

}  // namespace vasamesh::test

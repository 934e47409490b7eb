#pragma once

/// \file
/// How much memory reading may take.

#include <cstdint>
#include <string>

#include "io/volume_reader.h"

namespace vasamesh {

/// \throws Error refused when reading `path` takes more `bytes` than the options, or without a word
///         of theirs the machine, allow.
void check_memory(const std::string& path, std::int64_t bytes, const ReadOptions& options);

}  // namespace vasamesh

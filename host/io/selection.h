#pragma once

/// \file
/// Which voxels are object: one byte a voxel out of pixels of any type.

#include <string>
#include <vector>

#include "io/pixel_source.h"
#include "io/volume_reader.h"

namespace vasamesh {

/// One byte a pixel, 1 is object, for `count` pixels. \throws Error usage, bad_input: see
/// read_segmentation.
std::vector<std::uint8_t> select_object(const std::string& path, const PixelSource& pixels,
                                        std::size_t count, const ReadOptions& options);

}  // namespace vasamesh

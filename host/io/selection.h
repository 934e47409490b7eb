#pragma once

/// \file
/// Which voxels are object: one bit a voxel out of pixels of any type.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/pixel_source.h"
#include "io/volume_reader.h"

namespace vasamesh {

/// One bit a pixel, 1 is object (VoxelFormat::bits), for a volume of `size`. \throws Error usage,
/// bad_input: see read_segmentation.
std::vector<std::uint8_t> select_object(const std::string& path, const PixelSource& pixels,
                                        const std::array<std::int64_t, 3>& size,
                                        const ReadOptions& options);

}  // namespace vasamesh

#pragma once

/// \file
/// What ITK says about a volume, in our types.

#include <itkImageIOBase.h>

#include <string>

#include "io/pixel_source.h"

namespace vasamesh {

/// Lets ITK read the header. \throws Error bad_input where ITK refuses.
void read_itk_header(const std::string& path, itk::ImageIOBase& io);

/// Sizes, spacing, origin and direction in three dimensions. \throws Error bad_input: not 3D, a
/// series in time.
Geometry itk_geometry(const std::string& path, const itk::ImageIOBase& io);

/// \throws Error bad_input: vectors, colours, a type that is not one of ours.
PixelType itk_pixel_type(const std::string& path, const itk::ImageIOBase& io);

/// The number of voxels. \throws Error bad_input when their bytes might pass 2^63.
std::int64_t voxel_count(const std::string& path, const Geometry& geometry);

/// \throws Error bad_input: spacing zero, negative, not finite, absurd; origin not finite; a
///         direction that is sheared.
void check_geometry(const std::string& path, const Geometry& geometry);

/// \throws Error bad_input unless `size`, along one axis as the file has it, is a whole number
///         from 1 to 1e9. ITK takes what is left of it in 32 bits.
void check_raw_size(const std::string& path, double size);

/// \throws Error bad_input unless `spacing`, as the file has it, is finite and above zero.
void check_raw_spacing(const std::string& path, double spacing);

}  // namespace vasamesh

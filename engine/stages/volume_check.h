#pragma once

/// \file
/// What a volume must be before any work: a caller may hand in anything.

#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// \throws Error bad_input, naming the first of these: no address of voxels; a format that is none;
///         no or more than 2^20 voxels along an axis; a spacing that is not finite, not above zero
///         or absurd (1e-6 to 1e4 mm); an origin that is not finite; axes that are not orthonormal;
///         a place so far out that float32 coordinates in the space are more than 5 % of the
///         smallest spacing apart, too coarse for a proof.
void check_volume(const VolumeView& volume, Space space);

/// \throws Error bad_input, when there are no or more than 2^20 voxels along an axis.
void check_size(const Geometry& geometry);

}  // namespace vasamesh

#pragma once

/// \file
/// What a volume must be before any work: a caller may hand in anything.

#include <optional>
#include <string>

#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Why a volume cannot lie where it is said to, and what to do about it.
struct GeometryFault {
  std::string reason, remedy;
};

/// The first of these: a spacing that is not finite, not above zero or absurd (below 1e-6 or above
/// 1e4 mm); spacings that differ more than 100-fold; an origin that is not finite; axes whose
/// products are off by more than 0.001 from orthonormal ones'.
std::optional<GeometryFault> fault_of(const Geometry& geometry);

/// \throws Error bad_input, naming the first of these: no address of voxels; a format that is none;
///         no or more than 2^20 voxels along an axis; a fault of the geometry; a place so far out
///         that float32 coordinates in the space are more than 1 % of the smallest spacing apart:
///         there, the base surface of a smooth solid begins to fail its proof.
void check_volume(const VolumeView& volume, Space space);

/// What may be the reason, and what to do, where a surface fails its proof and coordinates are more
/// than 0.1 % of the smallest spacing apart: of noise on oblique axes, one triangle in a million is
/// then too small. Else empty.
std::string far_out(const Geometry& geometry, Space space);

/// From a value, at least zero and rounded to float32, to the next float32.
double float_step(double value);

/// \throws Error bad_input, when there are no or more than 2^20 voxels along an axis.
void check_size(const Geometry& geometry);

}  // namespace vasamesh

#pragma once

/// \file
/// Where the front starts: hexagons on the parts of the surface that it has not come to.

#include "backend/backend.h"
#include "stages/expand_front.h"
#include "stages/sizing.h"

namespace vasamesh {

/// Adds a hexagon at samples of the surface that lie more than two edge lengths from every vertex
/// of the front and about nine from one another. \return how many.
std::size_t add_seeds(Backend& backend, const FieldView& field, const SizeView& sizes,
                      const SurfaceSamples& samples, Front& front);

}  // namespace vasamesh

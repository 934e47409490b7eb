#pragma once

/// \file
/// The indicator function that the mesh stages evaluate, from the relabelled cell lattice.

#include <array>
#include <cstdint>

#include "backend/backend.h"
#include "types/indicator_field.h"
#include "types/lattice.h"
#include "types/point_cloud.h"

namespace vasamesh {

/// Owner of the function's table and coefficients.
struct IndicatorField {
  std::array<int, 3> grid{0, 0, 0};
  Buffer<std::int32_t> brick_at;
  Buffer<std::int32_t> neighbours;  ///< 27 a brick, as of types/bricks.h
  Buffer<float> coefficients;
  Scale step{0.5f, 0.5f, 0.5f};

  std::size_t brick_count() const { return coefficients.size() / kBrickCells; }
  FieldView view() const;
};

/// Coefficients whose spline takes the lattice's values at the nodes, to second order: value minus
/// one eighth of its second difference along each axis.
/// \param size  padded voxels along each axis, multiples of 8.
IndicatorField make_field(Backend& backend, const Lattice& lattice, const std::array<int, 3>& size,
                          const Scale& scale);

}  // namespace vasamesh

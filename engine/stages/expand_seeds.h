#pragma once

/// \file
/// Where the front starts: hexagons on the parts of the surface that it has not come to.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/expand_front.h"
#include "stages/sizing.h"

namespace vasamesh {

class FrontSeeds {
 public:
  FrontSeeds(const FieldView& field, const SizeView& sizes, const SurfaceSamples& samples);

  /// Adds a hexagon at samples of the surface that lie more than two edge lengths from every vertex
  /// of the front and about ten from one another. \return how many.
  std::size_t add(Backend& backend, Front& front);

 private:
  bool is_covered(const FrontView& front, std::uint32_t sample) const;
  void drop_covered(Backend& backend, const FrontView& front);

  const FieldView field_;
  const SizeView sizes_;
  const SurfaceSamples& samples_;
  std::vector<std::uint32_t> open_;  ///< samples that no vertex has been near, ascending
};

}  // namespace vasamesh

#pragma once

/// \file
/// Places of a surface that are to be treated with care, found through the cells of a grid.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "types/sizes.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh {

class Places {
 public:
  Places() = default;
  explicit Places(std::span<const CarefulPlace> places);

  /// The places of a view in the host's memory.
  explicit Places(const PlaceView& view);

  bool empty() const { return places_.empty(); }

  /// Whether a point lies in a place, or up to `margin` beyond; at most kMargin.
  bool hold(const Vec3& p, float margin = 0) const;

  /// The least factor of the places that hold a point; 1 where none does.
  float factor_at(const Vec3& p) const;

  /// Whether the input is to stay as it is in some of them.
  bool any_fixed() const;

  /// What a pass needs to find the factors; good as long as the places are there.
  PlaceView view() const;

  static constexpr float kMargin = 3;            ///< voxel lengths
  static constexpr float kInverseSide = 0.125f;  ///< of a cell, in voxel lengths

 private:
  template <class Visit>
  void for_each_near(const Vec3& p, const Visit& visit) const;

  std::vector<CarefulPlace> places_;
  std::vector<PlaceCell> cells_;  // sorted by cell, then by place
};

/// The places and as much round each, voxel lengths.
Places wider(std::span<const CarefulPlace> places, float by);

/// A byte a vertex: whether it lies in the places.
std::vector<std::uint8_t> vertices_in(Backend& backend, const Places& places,
                                      const TriangleMesh& mesh);

/// Adds balls round the points: one for each that no ball before it covers to half its radius.
void add_places(std::span<const Vec3> points, float radius, float factor,
                std::vector<CarefulPlace>& places);

/// The same from none.
std::vector<CarefulPlace> places_at(std::span<const Vec3> points, float radius, float factor);

}  // namespace vasamesh

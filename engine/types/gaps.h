#pragma once

/// \file
/// Gaps of a surface as polygons in flat arrays, and what the triangles over them must obey.

#include <cstddef>
#include <cstdint>

#include "types/buffer.h"
#include "types/indicator_field.h"
#include "types/vec3.h"

namespace vasamesh {

/// When a triangle or a chord over a gap counts as lying on the surface (stages/gap_rules.h).
struct GapRules {
  FieldView field;
  /// The least cosine between a triangle's normal and the surface's at its corners,
  float least_cosine = 0.5f;
  /// and at its middle.
  float middle_cosine = 0.5f;
  /// How far the middle of a chord, or of a triangle, may be from the surface, over its (longest)
  /// length.
  float reach = 0.35f;
};

/// Gap g has n = first[g + 1] - first[g] corners, 3 to 256, and its edges go from each to the next,
/// the last one's to its first. Its chords' table is n * n entries from chord_first[g] on.
struct GapView {
  View<const std::uint32_t> first, chord_first;  ///< gaps + 1 entries each
  View<const Vec3> points;                       ///< a corner, voxel lengths
  View<const Vec3> normals;  ///< a corner: the surface's outward unit normal there
  View<const Vec3> across;   ///< a corner: unit normal of the triangle across its edge, zero where
                             ///< there is none; may be empty where that is not asked for
  View<const std::uint8_t> chords;  ///< may corners i and j be joined: entry n i + j, symmetric

  std::size_t count() const { return first.size ? first.size - 1 : 0; }
};

}  // namespace vasamesh

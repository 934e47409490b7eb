#pragma once

/// \file
/// One gap at a time: what is tried to close it, from the strictest rules to the least strict.

#include <cstdint>
#include <span>
#include <vector>

#include "stages/gap_rim.h"
#include "stages/gap_rules.h"
#include "stages/triangulate_gap.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Gaps of more corners are not tried.
inline constexpr std::size_t kMostGapCorners = 256;

/// Corners of a gap that may not be joined, since another gap, or another place of this one, has
/// that edge.
struct TakenChord {
  std::uint16_t i, j;
};

struct GapClosing {
  enum Kind : std::uint8_t {
    open,          ///< nothing that was tried obeys
    triangulated,  ///< by chords
    starred        ///< by one vertex in its middle, joined to all corners
  };
  Kind kind = open;
  bool relaxed = false;  ///< the strictest rules left it open
  Vec3 middle;           ///< when starred: the vertex
};

/// Workspace and result; reused from gap to gap.
class GapCloser {
 public:
  /// Keeps references to the mesh and its rim.
  GapCloser(const FieldView& field, const TriangleMesh& mesh, const GapRim& rim, StitchMode mode)
      : field_(field), mesh_(mesh), rim_(rim), mode_(mode) {}

  /// Chords and triangles must follow the surface (gap_rules.h); a gap that no triangulation
  /// closes by the first rules is tried with others: triangles that turn farther from the
  /// surface's normals, a vertex in the middle, chords that leave the surface farther.
  /// \param loop     3 to kMostGapCorners vertices of the rim.
  /// \param annular  the loop turns so little that it may go round a tube: what could cap it is
  ///                 not tried.
  /// \param taken    chords that it may not have.
  GapClosing run(std::span<const std::uint32_t> loop, bool annular,
                 std::span<const TakenChord> taken);

  /// When triangulated: corners of the loop's size - 2 triangles (GapTriangulator).
  std::span<const std::uint16_t> triangles() const { return triangulator_.triangles(); }

 private:
  void load(std::span<const std::uint32_t> loop);
  void find_chords(std::span<const std::uint32_t> loop, std::span<const TakenChord> taken,
                   const GapRules& rules);
  Vec3 normal_across(std::uint32_t a, std::uint32_t b) const;
  bool close_by_star(const GapRules& rules, Vec3& middle) const;
  bool find_middle(Vec3& middle, Vec3& normal) const;

  const FieldView field_;
  const TriangleMesh& mesh_;
  const GapRim& rim_;
  const StitchMode mode_;
  std::vector<Vec3> points_, normals_, across_;
  std::vector<std::uint8_t> chords_;
  GapTriangulator triangulator_;
};

}  // namespace vasamesh

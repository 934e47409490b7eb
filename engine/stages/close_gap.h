#pragma once

/// \file
/// What is tried to close gaps, from the strictest rules to the least strict; all gaps at once,
/// each by itself.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/gap_rim.h"
#include "stages/triangulate_gap.h"
#include "types/gaps.h"
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

/// A gap to be closed, and where its closing goes.
struct GapToClose {
  std::span<const std::uint32_t> loop;  ///< 3 to kMostGapCorners vertices of the rim
  bool annular = false;           ///< the loop turns so little that it may go round a tube: what
                                  ///< could cap it is not tried
  std::vector<TakenChord> taken;  ///< chords that it may not have
  GapClosing* closing = nullptr;
  std::uint16_t* triangles = nullptr;  ///< when triangulated: corners of the loop's size - 2
                                       ///< triangles (GapTriangulator)
};

/// Buffers of the batches, kept from round to round.
class GapCloser {
 public:
  /// Keeps references to the backend, the mesh and its rim.
  /// \pre the field lies in the host's memory.
  GapCloser(Backend& backend, const FieldView& field, const TriangleMesh& mesh, const GapRim& rim,
            StitchMode mode)
      : backend_(backend), field_(field), mesh_(mesh), rim_(rim), mode_(mode) {}

  /// Chords and triangles must follow the surface (gap_rules.h); a gap that no triangulation
  /// closes by the first rules is tried with others: triangles that turn farther from the
  /// surface's normals, a vertex in the middle, chords that leave the surface farther.
  /// \param gaps  the largest first, so that the long ones do not come last.
  void run(std::span<const GapToClose> gaps);

 private:
  struct Attempt;
  static const Attempt kAttempts[];

  void close_batch(std::span<const GapToClose> gaps);
  bool is_possible(const GapToClose& gap) const;
  void load(std::span<const GapToClose* const> gaps);
  void load_gap(const GapToClose& gap, std::size_t g);
  Vec3 normal_across(std::uint32_t a, std::uint32_t b) const;
  GapView view() const;

  void triangulate(const GapRules& rules, std::span<const GapToClose* const> gaps);
  void close_by_stars(const GapRules& rules, std::span<const GapToClose* const> gaps);
  bool close_by_star(const GapRules& rules, const GapPolygon& polygon, Vec3& middle) const;
  bool find_middle(std::span<const Vec3> points, Vec3& middle, Vec3& normal) const;

  Backend& backend_;
  const FieldView field_;
  const TriangleMesh& mesh_;
  const GapRim& rim_;
  const StitchMode mode_;
  Buffer<std::uint32_t> first_, chord_first_;
  Buffer<Vec3> points_, normals_, across_;
  Buffer<std::uint8_t> chords_, closed_;
  Buffer<std::uint16_t> triangles_;
};

}  // namespace vasamesh

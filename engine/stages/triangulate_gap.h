#pragma once

/// \file
/// The triangulation of a gap by dynamic programming over its polygon, O(n^3): eq. 6 and 7 of the
/// paper.
///
/// Barequet, Sharir: Filling gaps in the boundary of a polyhedron, 1995; Liepa: Filling holes in
/// meshes, 2003 (the scheme); Musin: Properties of the Delaunay triangulation, 1997 (the harmonic
/// index).

#include <cstdint>
#include <span>
#include <vector>

#include "stages/gap_rules.h"
#include "types/gaps.h"
#include "types/vec3.h"
#include "vasamesh/parameters.h"

namespace vasamesh {

/// A gap's polygon; corner i's edge goes to corner i + 1, the last one's to corner 0.
struct GapPolygon {
  std::span<const Vec3> points;
  std::span<const Vec3> normals;  ///< the surface's outward unit normal at each corner
  std::span<const Vec3> across;   ///< a corner: unit normal of the triangle across its edge; zero
                                  ///< where there is none
  /// May corners i and j be joined where that follows the surface: entry n i + j, symmetric. Not
  /// asked for the polygon's edges.
  std::span<const std::uint8_t> chords;
};

/// Gap g of a batch; the views are in the host's memory.
GapPolygon gap_polygon(const GapView& gaps, std::size_t g);

/// Parts of gaps of about equal work, for tasks: where each starts, and the end.
/// \param corners  corners(i) of gap i.
template <class Corners>
std::vector<std::size_t> parts_of_gaps(std::size_t gaps, const Corners& corners) {
  constexpr std::size_t kTaskWork = 200000;
  std::vector<std::size_t> starts{0};
  std::size_t work = 0;
  for (std::size_t i = 0; i < gaps; ++i) {
    const std::size_t n = corners(i);
    work += n * n * n / 6 + 20 * n * n + 50 * n;
    if (work < kTaskWork && i + 1 < gaps) continue;
    starts.push_back(i + 1);
    work = 0;
  }
  return starts;
}

/// The additive cost of a triangle, from its squared edges, twice its area and the cosine of the
/// largest angle between its normal and the surface's at its corners: the harmonic index (least in
/// sum for the Delaunay triangulation, where the polygon is flat) times 2 - cosine (which keeps
/// the triangles on the surface, where it is not).
inline float triangle_cost(float squared_edges, float twice_area, float cosine) {
  return (squared_edges / twice_area) * (2.0f - cosine);
}

/// Workspace and result; reused from gap to gap.
class GapTriangulator {
 public:
  static constexpr std::size_t kMostCorners = 0xffff;

  /// Triangulates the polygon by chords and triangles that follow the surface (gap_rules.h), with
  /// n - 2 triangles (i, k, j), i < k < j: each before those of the part from i to k, and these
  /// before those from k to j. The same for any order of work; ties go to the lowest k.
  /// \return false where no triangulation obeys the rules and the chords.
  bool run(const GapPolygon& polygon, const GapRules& rules, StitchMode mode);

  /// Corners of the n - 2 triangles, three each, counter-clockwise.
  std::span<const std::uint16_t> triangles() const { return triangles_; }
  /// least_angle_measure of the worst triangle.
  float measure() const { return measure_; }
  /// The sum of triangle_cost in `exact` mode, of the areas in `paper` mode.
  float total() const { return total_; }

 private:
  void prepare();
  void minimise_measure();
  void minimise_cost();
  void minimise_lexicographic();
  void trace();
  float largest_turn(std::size_t i, std::size_t k, std::size_t j, const Vec3& normal) const;
  bool may_join(std::size_t i, std::size_t j) const {
    return j - i + 1 == n_ ||
           (polygon_.chords[n_ * i + j] != 0 &&
            chord_follows_surface(rules_, polygon_.points[i], polygon_.points[j]));
  }
  /// Whether the triangle's normal obeys the rules. \param product  of two of its edges, `squared`:
  /// its squared norm, `worst`: its least dot product with the normals at the corners.
  bool obeys_normals(std::size_t i, std::size_t k, std::size_t j, Vec3& product, float& squared,
                     float& worst) const;
  bool obeys_middle(std::size_t i, std::size_t k, std::size_t j, const Vec3& product) const;

  GapPolygon polygon_;
  GapRules rules_;
  std::size_t n_ = 0;
  // Entry n i + j belongs to the part of the polygon from corner i to j; symmetric, so that a
  // row holds what ends there as well as what starts there.
  std::vector<float> squared_;      ///< squared distances of corners
  std::vector<float> least_;        ///< measure of the best triangulation
  std::vector<float> sum_;          ///< its cost, or area
  std::vector<float> turn_;         ///< `paper`: minus the cosine of its largest dihedral angle
  std::vector<Vec3> top_;           ///< `paper`: unit normal of the triangle at edge i - j
  std::vector<std::uint16_t> via_;  ///< that triangle's third corner
  std::vector<float> candidate_;    ///< a third corner: a bound on what it gives
  std::vector<std::uint16_t> triangles_;
  float measure_ = 0, total_ = 0;
};

}  // namespace vasamesh

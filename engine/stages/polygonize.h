#pragma once

/// \file
/// Polygonization, the paper's second half: from the base surface and its indicator function to a
/// surface whose triangles follow the curvature. Hard regions are remeshed from the base surface
/// (hard.h, remesh.h), the front grows over the rest (expand.h), the gaps that it leaves are
/// stitched (stitch.h), and the whole is finished (finish.h).
///
/// Nothing here is proven: the caller checks each surface, has it judged, and takes the next until
/// one is good.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "scheduler.h"
#include "stages/field.h"
#include "stages/sizing.h"
#include "stages/solid_surface.h"
#include "stages/triangle_tree.h"
#include "types/lattice.h"
#include "vasamesh/errors.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// What is to be done with a surface.
enum class Verdict {
  take,  ///< nothing better is to be had
  keep,  ///< proven, and the best so far, but it leaves the segmentation somewhere
  refuse,
};

/// The number of triangles that is asked for is not to be had.
class CountRefused : public Error {
 public:
  /// \param possible  the nearest number that was found; `met`: which comes out when it is asked
  /// for.
  CountRefused(double wanted, double possible, bool met);
  double possible() const { return possible_; }

 private:
  double possible_;
};

class Polygonizer {
 public:
  /// \param size  padded voxels along each axis.
  /// \param base  the base surface, in padded voxel units.
  /// \throws CountRefused, when the triangles that are asked for are too few or too many for it.
  Polygonizer(Scheduler& scheduler, const Lattice& lattice, const std::array<int, 3>& size,
              const Scale& scale, TriangleMesh base, const Parameters& parameters);

  /// Whether the surface is smooth enough for edges of the lengths that are asked for: not noise,
  /// where handles are hardly larger than a few triangles.
  bool is_worthwhile(const Topology& topology) const;

  /// The next surface to prove, in padded voxel units; none when there is no other.
  ///
  /// First that of mesh expanding, then the same with the places that failed made again from the
  /// base surface, with ever shorter edges and at last as it is there. If none of these is proven,
  /// or too much of one has failed, or there is hardly any room for the front, the base surface
  /// remeshed as a whole, with the same care. Those that cannot have the right topology are not
  /// given out.
  std::optional<TriangleMesh> next();

  /// Judges the surface that next() gave last by its proof, by how far it leaves the segmentation
  /// and by its number of triangles, and plans the next.
  Verdict judge(const CheckReport& check);

  /// \throws CountRefused, where that is not the number of triangles that was asked for.
  void check_count(std::int64_t triangles) const;

  const MeshReport& report() const { return report_; }

 private:
  enum class Plan { expand, redo, remesh, stop };

  void aim();
  [[noreturn]] void refuse_count(double possible) const;
  bool count_is_right(std::int64_t triangles) const;
  bool aim_again(std::int64_t triangles);
  TriangleMesh made();
  double base_share() const;
  TriangleMesh expanded();
  TriangleMesh redone();
  TriangleMesh remeshed();
  TriangleMesh remeshed_instead();
  TriangleMesh settled(TriangleMesh mesh);
  std::optional<TriangleMesh> front_over(const TriangleMesh& patches);
  Backend& sizing() { return scheduler_.backend_for(Stage::sizing); }
  Backend& relaxing() { return scheduler_.backend_for(Stage::relax); }
  float longest_edge() const;
  float place_radius() const;
  void note(const std::vector<Vec3>& defects, std::span<const float> factors);
  bool can_be_redone() const;
  void plan_after(const std::vector<Vec3>& defects);
  void start_over(Plan plan);
  TriangleMesh in_voxels(TriangleMesh mesh) const;

  Scheduler& scheduler_;
  Backend& backend_;
  Scale scale_;
  StitchMode stitch_;
  SizeRule asked_, rule_;
  double wanted_triangles_ = 0;  ///< 0: as many as the rule gives
  TriangleMesh base_;            ///< voxel lengths
  double base_area_ = 0;         ///< square voxel lengths
  TriangleTree base_tree_;
  SolidSurface solid_;       ///< the segmentation's, voxel lengths
  TriangleTree solid_tree_;  ///< of what its surfaces have in common
  float limit_ = 0;          ///< that the surface may be from it
  IndicatorField field_;
  SizeField sizes_;
  Plan plan_ = Plan::expand;
  int aims_ = 0;
  double excess_ = 1;         ///< triangles of the last surface aimed at, over their prediction
  bool proven_ = false;       ///< some surface was
  int failures_ = 0;          ///< of the plan
  std::vector<Vec3> astray_;  ///< where the last surface and the segmentation are too far apart
  std::size_t least_astray_ = 0;
  std::vector<CarefulPlace> places_;  ///< where attempts have failed
  std::size_t first_fresh_ = 0;       ///< of the places: those of the last attempt follow
  TriangleMesh last_;                 ///< voxel lengths
  bool has_topology_ = false;         ///< the last surface has the base surface's, it seems
  bool settled_ = false;              ///< the last surface is, but in
  std::optional<std::size_t> work_;   ///< that is left for the settling of the plan's surfaces
  std::vector<CarefulPlace> changed_;
  MeshReport report_;
};

}  // namespace vasamesh

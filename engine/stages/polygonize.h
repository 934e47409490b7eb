#pragma once

/// \file
/// Polygonization, the paper's second half: from the base surface and its indicator function to a
/// surface whose triangles follow the curvature. Hard regions are remeshed from the base surface
/// (hard.h, remesh.h), the front grows over the rest (expand.h), the gaps that it leaves are
/// stitched (stitch.h), and the whole is finished (finish.h).
///
/// Nothing here is proven: the caller checks the surface, tells what came of it, and takes the
/// next, safer one until one passes.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler.h"
#include "stages/field.h"
#include "stages/sizing.h"
#include "types/lattice.h"
#include "vasamesh/parameters.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

class Polygonizer {
 public:
  /// \param size  padded voxels along each axis.
  /// \param base  the base surface, in padded voxel units.
  /// \throws Error usage, when the triangles that are asked for are too few or too many for it.
  Polygonizer(Scheduler& scheduler, const Lattice& lattice, const std::array<int, 3>& size,
              const Scale& scale, TriangleMesh base, const Parameters& parameters);

  /// The next surface to prove, in padded voxel units: of mesh expanding; the same with the places
  /// that failed made again from the base surface, with shorter edges from time to time and at last
  /// as it is there; the base surface remeshed as a whole; the base surface; then none.
  std::optional<TriangleMesh> next();

  /// Whether the surface that next() gave last follows the base surface everywhere. reject() it if
  /// not, even where its proof holds; the last attempt's is as near as can be had.
  bool follows_base();

  /// What became of the surface that next() gave last: the base surface stays where it failed.
  void reject();

  /// Whether the number of triangles is what was asked for. If not, next() aims at it once more.
  bool accept_count(std::int64_t triangles);

  const MeshReport& report() const { return report_; }

 private:
  enum class Method { expanded, remeshed, base, none };

  void aim(double triangles);
  TriangleMesh expanded();
  TriangleMesh redone();
  TriangleMesh remeshed();
  TriangleMesh front_over(const TriangleMesh& patches);
  void note_defects();
  void note(const std::vector<Vec3>& defects);
  TriangleMesh in_voxels(TriangleMesh mesh) const;

  Scheduler& scheduler_;
  Backend& backend_;
  Scale scale_;
  StitchMode stitch_;
  SizeRule asked_, rule_;
  double wanted_triangles_ = 0;  ///< 0: as many as the rule gives
  TriangleMesh base_;            ///< voxel lengths
  IndicatorField field_;
  SizeField sizes_;
  Method method_ = Method::expanded;
  int aims_ = 0;
  std::vector<CarefulPlace> places_;  ///< where attempts have failed
  std::size_t first_fresh_ = 0;       ///< of the places: those of the last attempt follow
  std::vector<Vec3> astray_;          ///< where the last surface leaves the base surface
  TriangleMesh last_;                 ///< voxel lengths
  MeshReport report_;
};

}  // namespace vasamesh

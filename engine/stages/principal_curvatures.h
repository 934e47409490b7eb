#pragma once

/// \file
/// The principal curvatures of a triangle surface at its vertices, for the figures of smoothness
/// (Section "Surface smoothness" of the paper, Figure 8).
///
/// Rusinkiewicz: Estimating curvatures and their derivatives on triangle meshes, 3DPVT 2004: in
/// each triangle the tensor that turns its edges into the differences of the vertices' normals
/// (least squares), at each vertex the mean of its triangles' tensors, turned into its tangent
/// plane and weighted by its share of their areas.

#include <vector>

#include "backend/backend.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// One entry a vertex; 0 at a vertex of no area.
struct PrincipalCurvatures {
  std::vector<float> most;   ///< kmax in 1 / mm, positive where an outward surface is convex
  std::vector<float> least;  ///< kmin <= kmax
  std::vector<float>
      area;  ///< of the surface nearest to the vertex, mm^2: the weight of an average

  /// sqrt((kmax^2 + kmin^2) / 2).
  std::vector<float> rms() const;
};

/// \pre the vertices are finite and the indices in range.
PrincipalCurvatures principal_curvatures(Backend& backend, const TriangleMesh& mesh);

}  // namespace vasamesh

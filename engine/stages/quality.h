#pragma once

/// \file
/// The quality of a surface's triangles: the edge ratio tau (shortest / longest edge), the least
/// angle, and how fast the size changes from one triangle to the next.

#include <vector>

#include "backend/backend.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Figures of a surface whose vertices are finite. Percentiles are exact (nearest rank); a figure
/// of no triangles is 0. The size ratio is taken over the edges that two triangles share.
QualityReport measure_quality(Backend& backend, const TriangleMesh& mesh);

/// Mean, deviation and nearest-rank percentiles; reorders `values`.
Distribution describe(std::vector<float>& values);

}  // namespace vasamesh

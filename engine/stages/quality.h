#pragma once

/// \file
/// The quality of a surface's triangles: the edge ratio tau (shortest / longest edge), the least
/// angle, the angles between triangles, and how fast the size changes from one to the next.

#include <cstdint>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Figures of a surface whose vertices are finite. Percentiles are exact (nearest rank); a figure
/// of no triangles is 0. Lengths, size ratios and dihedral angles are taken over the edges that two
/// triangles share.
QualityReport measure_quality(Backend& backend, const TriangleMesh& mesh);

/// The shapes one by one; an entry a triangle.
struct TriangleShapes {
  std::vector<float> edge_ratio;   ///< tau
  std::vector<float> least_angle;  ///< degrees
  std::vector<float> mean_edge;    ///< mm
  double area = 0, volume = 0;     ///< of the whole surface, as in the report
  std::int64_t close_pairs = 0;    ///< of edges of one triangle, longer / shorter at most 1.5
};
TriangleShapes triangle_shapes(Backend& backend, const TriangleMesh& mesh);

/// Mean, deviation and nearest-rank percentiles.
Distribution describe(const Backend& backend, std::span<const float> values);

/// The same of values that count by their weights, none below zero: a percentile is the least value
/// with that share of the weight at or below it. \pre both are of one length.
Distribution describe_weighted(const std::vector<float>& values, const std::vector<float>& weights);

}  // namespace vasamesh

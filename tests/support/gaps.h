#pragma once

/// \file
/// Surfaces with gaps cut out of them, and the fields that they sample.

#include <cstdint>
#include <random>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "stages/stitch.h"
#include "support/analytic_field.h"
#include "support/shapes.h"
#include "tbb/backend.h"
#include "types/mesh_vertex.h"

namespace vasamesh::test {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// oneTBB on two threads.
Backend& two_threads();

/// A surface, the field whose zero set it samples, and the length of its edges.
struct Scene {
  AnalyticField field;
  TriangleMesh mesh;
  float size;
};

Scene& ball();
Scene& ring();

StitchReport stitch(Scene& scene, TriangleMesh& mesh, StitchMode mode = StitchMode::exact);

/// The triangles that are not removed, and their vertices alone.
TriangleMesh without(const TriangleMesh& mesh, const std::vector<bool>& removed);

/// Without triangles of which `condition` holds for the centre.
template <class Condition>
TriangleMesh cut(const TriangleMesh& mesh, const Condition& condition) {
  std::vector<bool> removed(mesh.triangle_count());
  for (std::size_t t = 0; t < removed.size(); ++t) {
    Vec3 centre;
    for (int i = 0; i < 3; ++i)
      centre = centre + (1.0f / 3) * vertex_at(mesh, mesh.triangles[3 * t + i]);
    removed[t] = condition(centre);
  }
  return without(mesh, removed);
}

/// Removes patches of neighbouring triangles, each grown at random from a random triangle.
TriangleMesh with_random_holes(const TriangleMesh& mesh, int holes, int largest, unsigned seed);

std::multiset<Edge> directed_edges(const TriangleMesh& mesh);

float turning_of(AnalyticField& field, const TriangleMesh& mesh,
                 std::span<const std::uint32_t> loop);

}  // namespace vasamesh::test

#pragma once

/// \file
/// Negative controls: meshes that each break one invariant, and what a check must say of them.

#include <string>
#include <vector>

#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh::test {

/// The counts of CheckReport that tell defects; everything else of it is 0.
struct Defects {
  std::int64_t open_edges = 0, nonmanifold_edges = 0, misoriented_edges = 0,
               nonmanifold_vertices = 0, isolated_vertices = 0, degenerate_triangles = 0,
               nonfinite_vertices = 0, intersecting_pairs = 0, inverted_shells = 0;

  bool operator==(const Defects&) const = default;
};

Defects defects_of(const CheckReport& report);

struct BrokenMesh {
  std::string name;
  TriangleMesh mesh;
  Defects defects;
};

/// Defects of the way triangles are joined, of orientation and of single triangles.
std::vector<BrokenMesh> badly_joined_meshes();

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};

/// Closed manifold meshes that meet themselves, one of each kind.
std::vector<NamedMesh> self_intersecting_meshes();

}  // namespace vasamesh::test

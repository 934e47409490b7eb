#pragma once

/// \file
/// The shells of a surface (its connected components, joined by shared vertices): genus, volume
/// and nesting.

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/manifold.h"
#include "stages/triangle_tree.h"
#include "vasamesh/types.h"

namespace vasamesh {

struct Shell {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::int64_t vertices = 0, edges = 0, triangles = 0;
  double volume = 0;           ///< mm^3, positive when it faces outward
  bool nested = false;         ///< inside an odd number of other shells
  std::uint32_t next = kNone;  ///< the other shell met first along +x from the farthest vertex
  std::uint32_t first_vertex = 0;

  /// Of a closed manifold shell.
  std::int64_t genus() const { return (2 - (vertices - edges + triangles)) / 2; }
  bool outward() const { return volume > 0; }
  bool inverted() const { return nested ? volume >= 0 : volume <= 0; }
};

struct Shells {
  static constexpr std::uint32_t kNone = Shell::kNone;

  std::vector<Shell> shells;            ///< in order of their lowest triangles
  std::vector<std::uint32_t> shell_of;  ///< a vertex: its shell, kNone for isolated ones
};

/// Shells of the triangles with `valid` set, with everything but `nested` and `next`.
Shells find_shells(Backend& backend, const TriangleMesh& mesh,
                   const std::vector<std::uint8_t>& valid, const ManifoldCounts& manifold);

/// Sets `nested` (a ray along +x from the shell's farthest vertex crosses other shells an odd
/// number of times; exact) and `next`.
void find_nesting(Backend& backend, const TriangleMesh& mesh, const TriangleTree& tree,
                  Shells& shells);

}  // namespace vasamesh

#pragma once

/// \file
/// Shells of a few triangles, which operations could turn inside out: unlike a larger one, such a
/// shell has no triangles that would meet others on the way.

#include <cstdint>
#include <span>
#include <vector>

#include "stages/patch_mesh.h"
#include "types/vec3.h"

namespace vasamesh {

/// The shells of a part with at most kMost triangles: closed ones, and what the part has of one, if
/// it bulges like a shell from the rim where the part ends. Operations may change their vertices
/// and triangles, but join no two and divide none.
class SmallShells {
 public:
  using Corners = PatchMesh::Corners;

  static constexpr std::uint32_t kMost = 96;  ///< triangles

  explicit SmallShells(const PatchMesh& mesh);

  /// Takes up the triangle of the half-edge h, after any change of it.
  void take_up(const PatchMesh& mesh, std::uint32_t h);

  /// Whether the shell of `made`, if it is a small one, still holds half of the volume that it had
  /// at first with these triangles in place of those of the half-edges `gone`.
  bool keep_volume(const PatchMesh& mesh, std::span<const std::uint32_t> gone,
                   std::span<const Corners> made) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  struct Shell {
    std::vector<std::uint32_t> faces;  ///< first half-edges; some may be gone
    Vec3 origin;                       ///< of volumes: on the rim, if there is one
    double volume = 0;                 ///< at first
  };

  double volume(const PatchMesh& mesh, const Shell& shell) const;
  bool is_small(const PatchMesh& mesh, Shell& shell) const;

  std::vector<std::uint32_t> shell_of_;  // a vertex; kNone
  std::uint32_t end_ = 0;                // of the half-edges that have been taken up
  std::vector<Shell> shells_;
};

}  // namespace vasamesh

#pragma once

/// \file
/// A surface that is being remeshed, and passes over it in parallel: its triangles are divided by
/// the cells of a grid, each task works on the triangles of one cell as a PatchMesh of its own, and
/// the parts are joined in the order of the cells. Vertices with triangles in several cells stay
/// what they are; the grid moves from pass to pass, so that each vertex is inside in most of them.
/// The result depends on the surface and the grid alone.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "backend/backend.h"
#include "stages/patch_mesh.h"
#include "stages/patch_passes.h"
#include "types/sizes.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Vertices of no triangle may lie between the others.
struct WorkingSurface {
  std::vector<SurfacePoint> points;
  std::vector<std::uint8_t> fixed;  ///< a point: not to be moved or removed; empty: none is
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> resting;  ///< corners of triangles that no pass works on
  bool keeps_border = false;           ///< vertices on borders stay as they are
};

/// The grid of cells of a pass.
struct BlockGrid {
  float side = 16;  ///< voxel lengths
  float shift = 0;  ///< of the grid along each axis, as a part of the side, 0 to 1
};

/// The side of the blocks of most passes, voxel lengths: some twenty of the longest edges that are
/// asked for, so that parts have some thousand triangles.
inline float block_side(const SizeView& sizes) {
  return std::clamp(20 * sizes.elsewhere, 4.0f, 32.0f);
}

/// Calls work(part) for the part in each cell, in parallel, and joins what it leaves.
void for_each_block(Backend& backend, const BlockGrid& grid, WorkingSurface& surface,
                    const std::function<void(PatchMesh&)>& work);

/// The parts of a surface in the cells of a grid, all at once: for passes that take them together.
class SurfaceBlocks {
 public:
  /// Takes the surface apart; it must not be touched until join().
  SurfaceBlocks(Backend& backend, const BlockGrid& grid, WorkingSurface& surface);

  /// In the order of the cells.
  std::vector<PatchMesh*> parts();

  /// Writes the parts back and joins them, as for_each_block does.
  void join();

  /// A part, and the surface's vertices that its first ones are.
  struct Taken {
    PatchMesh mesh;
    std::vector<std::uint32_t> source;
  };

 private:
  Backend& backend_;
  WorkingSurface& surface_;
  std::vector<Taken> taken_;
};

/// work(part) for each part, in parallel.
void for_each_part(Backend& backend, std::span<PatchMesh* const> parts,
                   const std::function<void(PatchMesh&)>& work);

/// The surface to work on: normals from the field (the mean of the triangles' where the field has
/// none or denies it), sizes at the vertices. If the goal is local, triangles away from the places
/// rest, and borders stay as they are.
WorkingSurface make_working_surface(Backend& backend, const RemeshGoal& goal,
                                    const TriangleMesh& mesh);

/// Fixes the vertices in the goal's places of factor 0.
void fix_places(const Backend& backend, const RemeshGoal& goal, WorkingSurface& surface);

/// The mesh of what is left, its vertices in the order in which the triangles have them: near ones
/// lie near each other in memory.
TriangleMesh make_mesh(Backend& backend, const WorkingSurface& surface);

}  // namespace vasamesh

#pragma once

/// \file
/// The segmentation as a solid: its pieces, tunnels and cavities from counting the cells (voxels,
/// faces, edges, corners) of the voxel complex, and what else is found in the input. Works on runs
/// of voxels along x; nothing is held per voxel.
///
/// The solid of each connectivity, as a set of cells:
///   26  a cell is inside when any voxel that it touches is object (a union of closed voxels);
///   18  the same, trimmed at the corners where two object voxels meet in that corner alone;
///    6  a cell is inside when all voxels that it touches are object (an open solid).
/// Background is 6-connected for 26 and 18 (trimming a corner joins nothing: the six background
/// voxels round it are a ring), and 26-connected for 6.
///
/// Kong & Rosenfeld, Digital topology: introduction and survey, 1989.

#include <array>
#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "stages/runs.h"
#include "types/volume.h"
#include "vasamesh/report.h"

namespace vasamesh {

/// Which piece an object voxel belongs to.
struct PieceLookup {
  static constexpr std::int32_t kNone = -1;

  RunTable table;                   ///< the object's runs
  std::vector<std::int32_t> piece;  ///< a run: index into InputFindings::pieces

  /// The piece of padded voxel (x, y, z); kNone for background and outside the volume.
  std::int32_t at(int x, int y, int z) const;
};

struct Solid {
  InputFindings findings;
  Topology topology;  ///< sums over the pieces
  PieceLookup lookup;
};

/// Examines the whole segmentation. Places in the findings are the caller's voxels (padding taken
/// off); `anisotropy` and `dropped` are left for the caller.
///
/// \param object  in host memory; the outermost layer of the padded volume is background.
/// \param size  the caller's voxels along each axis, for the contacts with the border.
/// \throws Error refused, when there are more than 2^31 runs.
Solid examine_solid(Backend& backend, const BitView& object,
                    const std::array<std::int64_t, 3>& size, Connectivity connectivity);

/// Clears the pieces of fewer than `min_component` voxels from `object` and from `solid`.
/// Findings that are counted by place (contacts, one-voxel parts) are examined anew.
/// \return how many pieces were dropped, and where the first was; also in solid.findings.dropped.
Finding drop_small_components(Backend& backend, BitVolume& object,
                              const std::array<std::int64_t, 3>& size, Connectivity connectivity,
                              std::int64_t min_component, Solid& solid);

}  // namespace vasamesh

#pragma once

/// \file
/// The project's own inputs: segmentations of shapes that are known exactly, for tests, benchmarks,
/// the `phantom` subcommand and the demo. A voxel is object when its centre lies in the shape.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// What a phantom may be asked for. Unset fields take the phantom's own values.
struct PhantomOptions {
  std::uint64_t seed = 1;  ///< of trees and of speckle

  /// Voxels, 24 to 1024 each; `tree`, `full_box` and `speckle` only.
  std::optional<std::array<std::int64_t, 3>> size;

  /// Mm, 0.01 to 100, largest / smallest at most 20; not for `cerebral`, `liver`, `aorta`.
  std::optional<std::array<double, 3>> spacing;

  std::optional<double> radius;  ///< of the vessel, in voxels (geometric mean of the spacings),
                                 ///< 0.5 to 32; tubes, spheres and `tree` (its tips) only
  bool exact = false;            ///< make the exact surface too, where one exists
  double exact_step = 0;         ///< sampling step of the exact surface, as a fraction of the
                                 ///< smallest spacing, 0.1 to 1; 0: the phantom's own
};

/// A segmentation and what is known about it.
struct Phantom {
  std::string name;
  Geometry geometry;                  ///< identity direction, centred on the physical origin
  std::vector<std::uint8_t> voxels;   ///< 0 or 1, i fastest
  std::optional<TriangleMesh> exact;  ///< surface of the shape itself, mm, LPS, closed, outward
  bool has_exact = false;             ///< whether an exact surface exists (asked for or not)
  double least_radius = 0;  ///< of any vessel, in voxels (geometric mean); 0 for drawn voxels
  std::optional<Topology> topology;  ///< of the solid of closed voxels, where known beforehand

  VolumeView view() const { return {voxels.data(), VoxelFormat::bytes, geometry}; }
};

/// Every name that make_phantom() knows, in a fixed order; the three large trees last.
std::vector<std::string> phantom_names();

/// One line about a phantom, for people. \throws Error usage for an unknown name.
std::string phantom_summary(std::string_view name);

/// Makes a phantom; the same bytes for the same name and options.
/// \throws Error usage: an unknown name (the message lists the names), or an option out of its
///         range or of no meaning for that phantom.
Phantom make_phantom(std::string_view name, const PhantomOptions& options = {});

}  // namespace vasamesh

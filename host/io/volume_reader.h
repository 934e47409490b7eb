#pragma once

/// \file
/// Segmentations in and out of files: NIfTI (.nii, .nii.gz), MetaImage (.mha, .mhd), NRRD (.nrrd,
/// .seg.nrrd) and a folder that holds one DICOM series. ITK reads the headers, but for NIfTI's, and
/// the DICOM slices, and writes; other voxels are streamed once, to the checksum of a compressed
/// file, and selected as they come.

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vasamesh/types.h"

namespace vasamesh {

/// Which voxels of a volume are object. At most one of label, any_label and threshold may be set;
/// with none, the volume must hold one value beside 0, and that one is the object.
struct ReadOptions {
  std::optional<std::int64_t> label{};  ///< voxels of exactly this value
  bool any_label = false;               ///< voxels of any value but 0
  std::optional<double> threshold{};    ///< voxels of this value or above
  std::int64_t max_memory = 0;          ///< bytes that reading may hold; 0: the machine's memory
  const std::atomic<bool>* cancel = nullptr;  ///< set it to stop; may be null
};

/// A binary segmentation and where it lies: one byte a voxel, 1 is object, i varies fastest.
struct Segmentation {
  Geometry geometry;
  std::vector<std::uint8_t> voxels;

  /// A view of `voxels`; valid as long as this object lives unchanged.
  VolumeView view() const { return {voxels.data(), VoxelFormat::bytes, geometry}; }
};

/// The same, one bit a voxel, least significant first, each row of i padded to a whole byte.
struct PackedSegmentation {
  Geometry geometry;
  std::vector<std::uint8_t> bits;

  /// A view of `bits`; valid as long as this object lives unchanged.
  VolumeView view() const { return {bits.data(), VoxelFormat::bits, geometry}; }
};

/// Reads a segmentation of any scalar pixel type. Coordinates are LPS, in mm. A 2D image is one
/// slice, as thick as the geometric mean of its spacings; trailing axes of one entry are dropped.
///
/// \throws Error bad_input, one line that names the file, the reason and the remedy: no such file,
///         unknown format, truncated or corrupt, sizes that do not fit the file, not 3D, no scalar
///         pixels, spacing outside 1e-6 to 1e4 mm or of a ratio above 100, a unit of length that is
///         unknown or not the same along all axes, sheared direction, NaN,
///         infinite values without a threshold, no or several candidates for the object, an absent
///         label, nothing selected, a folder that is not exactly one DICOM series, or one with a
///         file that may be a slice and cannot be read, or with slices that do not lie evenly.
/// \throws Error usage, when more than one way of selection is asked for.
/// \throws Error refused, when the volume, or the voxels of one DICOM file as they are stored, need
///         more memory than allowed.
/// \throws Error cancelled, at most some milliseconds after `cancel` was set, but for the time that
///         ITK takes to read a DICOM series.
Segmentation read_segmentation(const std::string& path, const ReadOptions& options = {});

/// The same, in an eighth of the memory: no more than the bits and some chunks of the file is held.
PackedSegmentation read_packed(const std::string& path, const ReadOptions& options = {});

/// The file that a MetaImage or NRRD header names for its voxels; empty where there is none.
std::string voxel_file(const std::string& path);

/// Writes a segmentation as uint8, compressed where the format can: .nii, .nii.gz, .mha, .nrrd.
/// The file appears under its name only when it is complete.
///
/// \throws Error usage (unknown ending), refused (folder missing or not writable, disk full),
///         cancelled (`cancel` was set before it was complete).
void write_segmentation(const std::string& path, const Segmentation& segmentation,
                        const std::atomic<bool>* cancel = nullptr);

/// What write_segmentation would refuse, found before any work is done.
/// \throws Error usage (unknown ending), refused (folder missing or not writable; a folder, device
///         or pipe of that name).
void check_volume_path(const std::string& path);

}  // namespace vasamesh

#pragma once

/// \file
/// The formats of volumes: each reads the header, through ITK and beside it, refuses what ITK
/// would repair in silence, and says where the pixels are. No pixel is read here, but those of
/// DICOM on trial.

#include <string>

#include "io/pixel_source.h"
#include "io/volume_reader.h"

namespace vasamesh {

Volume open_nifti(const std::string& path);  ///< .nii, .nii.gz
Volume open_meta(const std::string& path);   ///< .mha, .mhd
Volume open_nrrd(const std::string& path);   ///< .nrrd
/// A folder with one series. \throws Error refused: a file whose voxels take more memory than the
/// options allow.
Volume open_dicom_series(const std::string& folder, const ReadOptions& options);

/// The file with the voxels, which may be `path`. \throws Error bad_input, as opening does.
std::string meta_voxel_file(const std::string& path);
std::string nrrd_voxel_file(const std::string& path);

}  // namespace vasamesh

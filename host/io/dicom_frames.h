#pragma once

/// \file
/// Where the frames of a DICOM file lie (DICOM PS3.3): a slice is one frame, placed by its image
/// plane (C.7.6.2); several frames are placed by functional groups, shared or each its own
/// (C.7.6.16).

#include <gdcmDataSet.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "types/vec3d.h"

namespace vasamesh {

/// What is stated, unchecked; nothing where it is absent or no list of numbers of that length.
struct DicomFrame {
  std::optional<Vec3d> position;                    ///< of the first pixel, ImagePositionPatient
  std::optional<std::array<Vec3d, 2>> orientation;  ///< along rows and columns
  std::optional<std::array<double, 2>> spacing;     ///< along rows and columns, PixelSpacing
  double thickness = 0;                             ///< 0: unknown
  std::string rescaling;  ///< in functional groups: slope and intercept, as text
  std::int64_t segment = 0;
};

/// The frames of a file that holds `count`: one, or as many as have functional groups, none where
/// there are none.
std::vector<DicomFrame> dicom_frames(const gdcm::DataSet& set, std::int64_t count);

}  // namespace vasamesh

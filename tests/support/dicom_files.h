#pragma once

/// \file
/// DICOM series for tests of our reader: written through ITK, then changed through GDCM.

#include <gdcmDataSet.h>
#include <gdcmFile.h>

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "vasamesh/types.h"

namespace vasamesh {

const gdcm::Tag kSeriesUid(0x0020, 0x000e), kPixels(0x7fe0, 0x0010), kSpacing(0x0028, 0x0030);
const gdcm::Tag kPosition(0x0020, 0x0032), kOrientation(0x0020, 0x0037);

/// Slices of a rotated volume with 0.7 x 0.7 x 1.25 mm voxels.
Geometry series_geometry(bool mirrored);

/// `object` in every third voxel or so, else 0.
std::vector<std::int16_t> random_pixels(const Geometry& geometry, std::int16_t object);

/// Decimal strings, as DICOM separates them.
std::string decimals(const double* values, std::size_t count);
template <std::size_t N>
std::string decimals(const std::array<double, N>& values) {
  return decimals(values.data(), N);
}

/// Writes a series into `folder`, the end of its UID being `series`: slice k of n has the name
/// SERIES_I.dcm with I = (5 k + 3) % n.
void write_series(const std::string& folder, const Geometry& geometry,
                  const std::vector<std::int16_t>& pixels, const std::string& series);

/// Six slices of series_geometry() in `folder`; the last is 7_4.dcm. \return their geometry
Geometry write_slices(const std::string& folder);

/// Changes a file.
void edit_file(const std::string& path, const std::function<void(gdcm::File&)>& change);

/// Changes the elements of a file.
void edit(const std::string& path, const std::function<void(gdcm::DataSet&)>& change);

/// Sets an element of text.
void set_text(gdcm::DataSet& set, const gdcm::Tag& tag, const gdcm::VR& vr, std::string text);

/// Sets an element of one 16-bit integer.
void set_unsigned(gdcm::DataSet& set, const gdcm::Tag& tag, std::uint16_t value);

/// Sets an element of decimal strings in a file.
void set_decimals(const std::string& path, const gdcm::Tag& tag, const std::string& text);

/// What a file of several frames holds, each as large as the geometry says.
struct DicomFrames {
  Geometry geometry = series_geometry(false);
  std::vector<std::int16_t> pixels = random_pixels(geometry, 1);
  std::vector<std::array<double, 3>> positions = {};  ///< of each frame
  std::vector<std::uint16_t> segments = {};           ///< none, or of each frame
};

/// Frame k of the file is slice order[k] of series_geometry().
DicomFrames frames_in_order(const std::vector<int>& order);

/// Writes one file of several frames into `folder`, 7_0.dcm.
void write_frames(const std::string& folder, const DicomFrames& frames);

/// The message of the error bad_input that reading ends with; nothing may be printed.
std::string dicom_error_of(const std::string& path);

}  // namespace vasamesh

#pragma once

/// \file
/// What the header of a DICOM file says (DICOM PS3.3), as far as a series needs it. GDCM parses it;
/// Debian's is built with assertions, which damaged files trip: read on trial first (trial.h).

#include <cstdint>
#include <string>
#include <vector>

#include "io/dicom_frames.h"

namespace vasamesh {

struct DicomFile {
  std::string path;
  std::string series;         ///< SeriesInstanceUID; empty where there is none
  bool is_directory = false;  ///< a DICOMDIR
  bool is_localizer = false;  ///< a scout image, on which slices are planned
  bool has_pixels = false, has_float_pixels = false;
  bool has_imager_spacing = false;  ///< ImagerPixelSpacing
  std::int64_t columns = 0, rows = 0, frame_count = 1;
  std::int64_t samples = 1;         ///< a pixel
  std::int64_t bits_allocated = 0;  ///< a sample
  bool is_raw = false;              ///< the pixels lie in the file as they are
  bool is_big_endian = false;
  std::int64_t pixels_begin = 0;   ///< where, if they are raw
  std::vector<DicomFrame> frames;  ///< those that are described
};

/// Parses the header, up to the pixels. \throws Error bad_input: it cannot be parsed.
DicomFile read_dicom_file(const std::string& path);

/// The error of a file whose header is damaged.
[[noreturn]] void throw_damaged_header(const std::string& path);

}  // namespace vasamesh

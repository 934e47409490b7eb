#pragma once

/// \file
/// How the frames of a series lie on each other. Nothing is guessed: spacings are those that the
/// files state within a slice, and measured from the positions between slices.

#include <cstddef>
#include <string>
#include <vector>

#include "io/dicom_file.h"
#include "vasamesh/types.h"

namespace vasamesh {

struct DicomStack {
  Geometry geometry;
  std::vector<std::vector<std::size_t>> slices;  ///< [file][frame]: which slice of the volume
};

/// Orders the frames along the normal of their plane.
/// \throws Error bad_input, naming the file, and the frame of several: no PixelSpacing, positions
///         or orientation; several segments; frames that differ in size, spacing or orientation,
///         that lie in one place, unevenly, or displaced within their plane (tolerance: a tenth
///         of the step).
DicomStack dicom_stack(const std::vector<DicomFile>& files);

}  // namespace vasamesh

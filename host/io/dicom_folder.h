#pragma once

/// \file
/// The files of a folder with one DICOM series. Every file that is or may be a slice is accounted
/// for: none is left out in silence because it is damaged or cannot be read.

#include <string>
#include <vector>

#include "io/dicom_file.h"

namespace vasamesh {

/// The files in `folder` that must be DICOM by their first bytes or by their name, in the order of
/// the names; none is parsed. Left aside are DICOMDIR, hidden files, folders, what is no file (a
/// FIFO, a socket, a device), and files that are evidently none, as texts and pictures are.
/// \throws Error bad_input, naming the entry: the folder or a file cannot be read, a link leads
///         nowhere, a file that may be a slice is empty or holds no DICOM.
std::vector<std::string> list_dicom_folder(const std::string& folder);

/// Those of `files` that are the slices of the only series in `folder`, parsed, in the same order.
/// Left aside are objects without pixels that belong to another series (reports, presentation
/// states), and series of scout images beside another.
/// \throws Error bad_input: no series, several, a file that is damaged or lacks its pixels.
std::vector<DicomFile> dicom_series(const std::string& folder,
                                    const std::vector<std::string>& files);

}  // namespace vasamesh

#pragma once

/// \file
/// Where a NIfTI-1 header places its voxels (nifti1.h, "3D image orientation and location in
/// space"), turned from its RAS into LPS.
///
/// The choice between sform and qform is ITK's (5.2, NiftiImageIO). ITK itself is not asked, since
/// this version refuses headers that have a good sform and no qform, takes the voxel's size from
/// pixdim whatever the sform says, and repairs a spacing of zero or below in silence.

#include <nifti1.h>

#include <string>

#include "vasamesh/types.h"

namespace vasamesh {

/// \param header  in the machine's byte order, dim[0] from 2 to 7.
/// \throws Error bad_input: a spacing not above zero; a sform that is sheared, with no qform to
///         take its place; a sform that disagrees with pixdim; more than one volume.
Geometry nifti_geometry(const std::string& path, const nifti_1_header& header);

}  // namespace vasamesh

#include "io/nifti_geometry.h"

#include <nifti1_io.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/io_error.h"
#include "io/itk_header.h"

namespace vasamesh {
namespace {

constexpr double kTolerance = 1e-3;

using Vector = std::array<double, 3>;

/// Columns: where one step along each axis leads, and where voxel (0, 0, 0) is. RAS.
using Transform = std::array<Vector, 4>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double length(const Vector& a) { return std::sqrt(dot(a, a)); }

Transform sform(const nifti_1_header& header) {
  Transform columns;
  for (int i = 0; i < 4; ++i) columns[i] = {header.srow_x[i], header.srow_y[i], header.srow_z[i]};
  return columns;
}

Transform qform(const nifti_1_header& header) {
  const mat44 matrix = nifti_quatern_to_mat44(
      header.quatern_b, header.quatern_c, header.quatern_d, header.qoffset_x, header.qoffset_y,
      header.qoffset_z, header.pixdim[1], header.pixdim[2],
      header.dim[0] > 2 ? header.pixdim[3] : 1, header.pixdim[0] < 0 ? -1.0f : 1.0f);
  Transform columns;
  for (int i = 0; i < 4; ++i) columns[i] = {matrix.m[0][i], matrix.m[1][i], matrix.m[2][i]};
  return columns;
}

bool is_finite(const Transform& transform) {
  return std::all_of(transform.begin(), transform.end(), [](const Vector& column) {
    return std::all_of(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
  });
}

bool is_sheared(const Transform& transform) {
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double lengths = length(transform[a]) * length(transform[b]);
    if (!(std::abs(dot(transform[a], transform[b])) <= kTolerance * lengths) || lengths == 0) {
      return true;
    }
  }
  return false;
}

bool is_similar(const Transform& a, const Transform& b) {
  constexpr double kSimilar = 1e-4;
  for (int i = 0; i < 4; ++i) {
    for (int row = 0; row < 3; ++row) {
      if (!(std::abs(a[i][row] - b[i][row]) <= kSimilar)) return false;
    }
  }
  return true;
}

bool prefers_sform(const nifti_1_header& header) {
  if (header.sform_code <= 0 || is_sheared(sform(header))) return false;
  return header.qform_code <= 0 || header.sform_code == NIFTI_XFORM_SCANNER_ANAT ||
         is_similar(sform(header), qform(header));
}

/// Without sform and qform the axes are those of LPS, as in ITK.
Transform choose_transform(const std::string& path, const nifti_1_header& header) {
  if (prefers_sform(header)) return sform(header);
  if (header.qform_code > 0) return qform(header);
  if (header.sform_code > 0) {
    if (!is_finite(sform(header))) {
      throw_bad_input(path, "its sform is not finite", "correct its header");
    }
    throw_bad_input(path, "its sform is sheared: its axes are not at right angles",
                    "resample the volume on orthogonal axes");
  }
  return {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, 0}}};
}

double unit_in_mm(const nifti_1_header& header) {
  switch (XYZT_TO_SPACE(header.xyzt_units)) {
    case NIFTI_UNITS_METER:
      return 1e3;
    case NIFTI_UNITS_MICRON:
      return 1e-3;
    default:
      return 1;
  }
}

void check_pixdim(const std::string& path, const nifti_1_header& header) {
  for (int axis = 0; axis < 3 && axis < header.dim[0]; ++axis) {
    const double spacing = header.pixdim[axis + 1];
    check_raw_spacing(path, spacing);
    if (!prefers_sform(header)) continue;
    if (std::abs(length(sform(header)[axis]) - spacing) > kTolerance * spacing) {
      throw_bad_input(path, "its sform and its spacing (pixdim) disagree", "correct its header");
    }
  }
}

}  // namespace

Geometry nifti_geometry(const std::string& path, const nifti_1_header& header) {
  check_pixdim(path, header);
  const Transform transform = choose_transform(path, header);
  const double unit = unit_in_mm(header);
  const bool flat = header.dim[0] == 2;
  Geometry geometry;
  for (int axis = 0; axis < 3; ++axis) {
    const double lps = axis < 2 ? -1 : 1;
    geometry.origin[axis] = lps * unit * transform[3][axis];
    for (int column = 0; column < 3; ++column) {
      geometry.direction[3 * axis + column] =
          lps * transform[column][axis] / length(transform[column]);
    }
    geometry.size[axis] = axis == 2 && flat ? 1 : header.dim[axis + 1];
    geometry.spacing[axis] = unit * (axis == 2 && flat ? 1 : header.pixdim[axis + 1]);
  }
  if (flat) geometry.spacing[2] = std::sqrt(geometry.spacing[0] * geometry.spacing[1]);
  return geometry;
}

}  // namespace vasamesh

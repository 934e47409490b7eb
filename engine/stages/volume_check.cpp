#include "stages/volume_check.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::int64_t kMaxSize = 1 << 20;  // voxels along an axis
constexpr double kLeastSpacing = 1e-6, kMostSpacing = 1e4, kMostAnisotropy = 100;
constexpr double kOrthonormal = 1e-3;                      // error of the products of axes
constexpr double kCoarsestStep = 0.01, kFineStep = 0.001;  // of the smallest spacing

[[noreturn]] void refuse(const std::string& reason) { throw Error(ErrorCode::bad_input, reason); }

/// As short as it can be written.
std::string text_of(double number) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

bool are_orthonormal(const std::array<double, 9>& columns) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      double product = 0;
      for (std::size_t row = 0; row < 3; ++row)
        product += columns[3 * row + a] * columns[3 * row + b];
      if (!(std::fabs(product - (a == b ? 1 : 0)) <= kOrthonormal)) return false;
    }
  return true;
}

/// The largest coordinate that the volume may reach, without its sign, whatever its direction.
double farthest_coordinate(const Geometry& geometry) {
  double reach = 0, origin = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = geometry.spacing[axis] * static_cast<double>(geometry.size[axis]);
    reach += length * length;
    origin = std::max(origin, std::fabs(geometry.origin[axis]));
  }
  return origin + std::sqrt(reach);
}

/// Of the smallest spacing, the most that float32 coordinates are apart.
double coarsest_step(const Geometry& geometry) {
  return float_step(farthest_coordinate(geometry)) /
         *std::min_element(geometry.spacing.begin(), geometry.spacing.end());
}

void check_resolution(const Geometry& geometry) {
  const double farthest = farthest_coordinate(geometry);
  if (coarsest_step(geometry) > kCoarsestStep)
    refuse("the volume reaches out to about " +
           std::to_string(std::llround(std::min(farthest, 1e18))) +
           " mm, where float32 coordinates are more than 1 % of its spacing apart: use --space "
           "voxel, or correct its origin");
}

}  // namespace

double float_step(double value) {
  using Limits = std::numeric_limits<float>;
  const auto rounded = static_cast<float>(std::min(value, double{Limits::max()}));
  return double{std::nextafter(rounded, Limits::infinity())} - rounded;
}

std::optional<GeometryFault> fault_of(const Geometry& geometry) {
  const std::string correct_spacing = "correct the spacing in its header (mm)";
  for (const double spacing : geometry.spacing) {
    if (!(std::isfinite(spacing) && spacing > 0))
      return {
          {"its spacing is " + text_of(spacing) + ", not a length above zero", correct_spacing}};
    if (spacing < kLeastSpacing || spacing > kMostSpacing)
      return {{"its spacing of " + text_of(spacing) + " mm is absurd", correct_spacing}};
  }
  const auto [least, most] = std::minmax_element(geometry.spacing.begin(), geometry.spacing.end());
  if (*most > kMostAnisotropy * *least)
    return {{"its spacings, " + text_of(*least) + " and " + text_of(*most) +
                 " mm, differ more than " + text_of(kMostAnisotropy) + "-fold",
             correct_spacing}};
  for (const double origin : geometry.origin)
    if (!std::isfinite(origin))
      return {{"its origin is not finite", "correct the origin in its header"}};
  if (!are_orthonormal(geometry.direction))
    return {{"its direction matrix is sheared or scaled, not orthonormal",
             "resample the volume on orthogonal axes"}};
  return std::nullopt;
}

void check_size(const Geometry& geometry) {
  for (const std::int64_t size : geometry.size)
    if (size < 1 || size > kMaxSize)
      refuse("the volume has " + std::to_string(size) + " voxels along an axis: give 1 to " +
             std::to_string(kMaxSize));
}

void check_volume(const VolumeView& volume, Space space) {
  if (!volume.data) refuse("the volume has no voxels: give their address");
  if (volume.format != VoxelFormat::bytes && volume.format != VoxelFormat::bits)
    refuse("the volume's format is none: give bytes or bits");
  check_size(volume.geometry);
  if (const auto fault = fault_of(volume.geometry))
    refuse("the volume cannot be used, " + fault->reason + ": " + fault->remedy);
  if (space != Space::voxel) check_resolution(volume.geometry);  // there no axis is long enough
}

std::string far_out(const Geometry& geometry, Space space) {
  if (space == Space::voxel || coarsest_step(geometry) <= kFineStep) return {};
  return "; so far out float32 coordinates may be too coarse for it: use --space voxel";
}

}  // namespace vasamesh

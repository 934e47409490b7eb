#include "io/itk_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/io_error.h"
#include "stages/volume_check.h"

namespace vasamesh {
void read_itk_header(const std::string& path, itk::ImageIOBase& io) {
  try {
    io.SetFileName(path);
    io.ReadImageInformation();
  } catch (const itk::ExceptionObject&) {
    throw_bad_input(path, "its header cannot be read", "write the volume again");
  }
}

Geometry itk_geometry(const std::string& path, const itk::ImageIOBase& io) {
  const int dimensions = static_cast<int>(io.GetNumberOfDimensions());
  if (dimensions < 2) throw_bad_input(path, "it is not a 3D volume", "give a 3D segmentation");
  Geometry geometry;
  for (int axis = 0; axis < dimensions; ++axis) {
    const auto size = static_cast<std::int64_t>(io.GetDimensions(axis));
    if (axis >= 3 && size > 1) {
      throw_bad_input(path, fmt::format("it is a series of {} volumes, not one", size),
                      "extract the volume to convert");
    }
    if (axis >= 3) continue;
    geometry.size[axis] = size;
    geometry.spacing[axis] = io.GetSpacing(axis);
    geometry.origin[axis] = io.GetOrigin(axis);
    const std::vector<double> column = io.GetDirection(axis);
    for (int row = 0; row < std::min(dimensions, 3); ++row) {
      geometry.direction[3 * row + axis] = column[row];
    }
  }
  if (dimensions == 2) {
    geometry.size[2] = 1;
    geometry.spacing[2] = std::sqrt(geometry.spacing[0] * geometry.spacing[1]);
  }
  return geometry;
}

PixelType itk_pixel_type(const std::string& path, const itk::ImageIOBase& io) {
  if (io.GetNumberOfComponents() != 1) {
    throw_bad_input(
        path,
        fmt::format("its voxels have {} components each, not one", io.GetNumberOfComponents()),
        "write one label map (merge colours, vectors or segment layers)");
  }
  using Type = itk::IOComponentEnum;
  switch (io.GetComponentType()) {
    case Type::CHAR:
      return PixelType::int8;
    case Type::UCHAR:
      return PixelType::uint8;
    case Type::SHORT:
      return PixelType::int16;
    case Type::USHORT:
      return PixelType::uint16;
    case Type::INT:
      return PixelType::int32;
    case Type::UINT:
      return PixelType::uint32;
    case Type::LONG:
      return sizeof(long) == 8 ? PixelType::int64 : PixelType::int32;
    case Type::ULONG:
      return sizeof(long) == 8 ? PixelType::uint64 : PixelType::uint32;
    case Type::LONGLONG:
      return PixelType::int64;
    case Type::ULONGLONG:
      return PixelType::uint64;
    case Type::FLOAT:
      return PixelType::float32;
    case Type::DOUBLE:
      return PixelType::float64;
    default:
      throw_bad_input(path, "its pixel type is not a scalar", "write it as integers");
  }
}

std::int64_t voxel_count(const std::string& path, const Geometry& geometry) {
  constexpr std::int64_t kMost = (std::int64_t{1} << 60) - 1;
  std::int64_t count = 1;
  for (const std::int64_t size : geometry.size) {
    if (size < 1 || count > kMost / size) {
      throw_bad_input(path,
                      fmt::format("its size, {} x {} x {} voxels, is impossible", geometry.size[0],
                                  geometry.size[1], geometry.size[2]),
                      "write the volume again");
    }
    count *= size;
  }
  return count;
}

void check_raw_size(const std::string& path, double size) {
  constexpr double kMost = 1e9;
  if (size >= 1 && size < kMost && size == std::floor(size)) return;
  throw_bad_input(path, fmt::format("its size of {} voxels along an axis is impossible", size),
                  "correct the sizes in its header, or write the volume again");
}

void check_raw_spacing(const std::string& path, double spacing) {
  if (std::isfinite(spacing) && spacing > 0) return;
  throw_bad_input(path, fmt::format("its spacing is {}, not a length above zero", spacing),
                  "correct the spacing in its header");
}

void check_geometry(const std::string& path, const Geometry& geometry) {
  if (const auto fault = fault_of(geometry)) throw_bad_input(path, fault->reason, fault->remedy);
}

}  // namespace vasamesh

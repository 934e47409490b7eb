/// \file
/// NIfTI-1 in one file (nifti1.h of the NIfTI Data Format Working Group).

#include <nifti1_io.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/nifti_geometry.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

constexpr int kHeaderBytes = 348, kNifti2HeaderBytes = 540;
static_assert(sizeof(nifti_1_header) == kHeaderBytes);

/// The header in the machine's byte order, and whether that is not the file's.
struct Header {
  nifti_1_header fields{};
  bool swapped = false;
};

void check_compressed(const std::string& path) {
  std::array<unsigned char, 2> magic{};
  ByteStream(path, 0, Encoding::raw).read(magic.data(), magic.size());
  if (magic == std::array<unsigned char, 2>{0x1f, 0x8b}) return;
  throw_bad_input(path, "it is not gzip-compressed though its name ends in .gz",
                  "rename it without .gz, or get a whole copy of the file");
}

Header read_header(const std::string& path, Encoding encoding) {
  if (encoding == Encoding::deflate) check_compressed(path);
  Header header;
  const std::size_t bytes =
      ByteStream(path, 0, encoding).read(&header.fields, sizeof(header.fields));
  std::int32_t size = header.fields.sizeof_hdr;
  header.swapped = size != kHeaderBytes && size != kNifti2HeaderBytes;
  if (header.swapped) {
    swap_nifti_header(&header.fields, 1);
    size = header.fields.sizeof_hdr;
  }
  if (size == kNifti2HeaderBytes) {
    throw_bad_input(path, "it is NIfTI-2, which is not supported", "write it as NIfTI-1");
  }
  if (bytes < sizeof(header.fields) || size != kHeaderBytes ||
      std::memcmp(header.fields.magic, "n+1", 4) != 0) {
    throw_bad_input(path, "it is no NIfTI file", "check its format");
  }
  return header;
}

PixelType pixel_type(const std::string& path, const nifti_1_header& header) {
  switch (header.datatype) {
    case NIFTI_TYPE_INT8:
      return PixelType::int8;
    case NIFTI_TYPE_UINT8:
      return PixelType::uint8;
    case NIFTI_TYPE_INT16:
      return PixelType::int16;
    case NIFTI_TYPE_UINT16:
      return PixelType::uint16;
    case NIFTI_TYPE_INT32:
      return PixelType::int32;
    case NIFTI_TYPE_UINT32:
      return PixelType::uint32;
    case NIFTI_TYPE_INT64:
      return PixelType::int64;
    case NIFTI_TYPE_UINT64:
      return PixelType::uint64;
    case NIFTI_TYPE_FLOAT32:
      return PixelType::float32;
    case NIFTI_TYPE_FLOAT64:
      return PixelType::float64;
    default:
      throw_bad_input(path, "its voxels are not scalar numbers of 8 to 64 bits",
                      "write one label map");
  }
}

std::int64_t check_dimensions(const std::string& path, const nifti_1_header& header) {
  if (header.dim[0] < 2 || header.dim[0] > 7) {
    throw_bad_input(path, "it is not a 3D volume", "give a 3D segmentation");
  }
  std::int64_t count = 1;
  for (int i = 1; i <= header.dim[0]; ++i) {
    if (header.dim[i] < 1) {
      throw_bad_input(path, "its size is below one voxel", "write the volume again");
    }
    if (i > 3 && header.dim[i] > 1) {
      throw_bad_input(
          path,
          i == 4 ? "it is a series of " + std::to_string(header.dim[i]) + " volumes, not one"
                 : "its voxels have several components each, not one",
          "extract the volume to convert");
    }
    count *= header.dim[i];
  }
  return count;
}

std::int64_t voxel_offset(const std::string& path, const nifti_1_header& header) {
  if (!(header.vox_offset >= kHeaderBytes && header.vox_offset < 1e15f)) {
    throw_bad_input(path, "its voxels lie at an impossible offset", "write the volume again");
  }
  return static_cast<std::int64_t>(header.vox_offset);
}

// A slope of 0 means that the pixels are the values.
void set_rescaling(const nifti_1_header& header, PixelLayout& layout) {
  if (!std::isfinite(header.scl_slope) || header.scl_slope == 0) return;
  layout.slope = header.scl_slope;
  layout.intercept = std::isfinite(header.scl_inter) ? header.scl_inter : 0;
}

}  // namespace

Volume open_nifti(const std::string& path) {
  PixelLayout layout;
  layout.file = path;
  layout.encoding = file_ending(path, {".gz"}).empty() ? Encoding::raw : Encoding::deflate;
  const Header header = read_header(path, layout.encoding);
  layout.count = check_dimensions(path, header.fields);
  layout.type = pixel_type(path, header.fields);
  layout.skip = voxel_offset(path, header.fields);
  layout.swap_bytes = header.swapped;
  set_rescaling(header.fields, layout);
  return {nifti_geometry(path, header.fields), make_file_pixels(path, layout)};
}

}  // namespace vasamesh

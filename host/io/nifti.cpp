/// \file
/// NIfTI-1 (nifti1.h of the NIfTI Data Format Working Group). ITK repairs a spacing of zero or
/// below in silence, and takes the voxel's size from pixdim whatever the sform says: the header's
/// own bytes are looked at for these.

#include <itkNiftiImageIO.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

constexpr std::size_t kHeaderBytes = 348;
constexpr int kNifti2HeaderBytes = 540;

/// The fields of the header, by their offsets in it.
class NiftiHeader {
 public:
  NiftiHeader(const std::string& path, Encoding encoding) {
    ByteStream stream(path, 0, encoding);
    const std::size_t bytes = stream.read(bytes_.data(), kHeaderBytes);
    swap_ = size() != kHeaderBytes;
    if (bytes >= 4 && is_nifti2()) {
      throw_bad_input(path, "it is NIfTI-2, which is not supported", "write it as NIfTI-1");
    }
    const bool magic = std::memcmp(bytes_.data() + 344, "n+1", 4) == 0;
    if (bytes < kHeaderBytes || size() != kHeaderBytes || !magic) {
      throw_bad_input(path, "it is no NIfTI file", "check its format");
    }
  }

  bool swapped() const { return swap_; }
  int dimension(int i) const { return field<std::int16_t>(40 + 2 * i); }
  int datatype() const { return field<std::int16_t>(70); }
  double pixdim(int i) const { return field<float>(76 + 4 * i); }
  double voxel_offset() const { return field<float>(108); }
  double slope() const { return field<float>(112); }
  double intercept() const { return field<float>(116); }
  bool has_qform() const { return field<std::int16_t>(252) > 0; }
  bool has_sform() const { return field<std::int16_t>(254) > 0; }
  double sform(int row, int column) const { return field<float>(280 + 16 * row + 4 * column); }

 private:
  template <class T>
  T field(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), bytes_.data() + offset, sizeof(T));
    if (swap_) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }
  std::size_t size() const { return static_cast<std::size_t>(field<std::int32_t>(0)); }
  bool is_nifti2() const {
    std::int32_t size;
    std::memcpy(&size, bytes_.data(), sizeof(size));
    return size == kNifti2HeaderBytes ||
           size == static_cast<std::int32_t>(__builtin_bswap32(kNifti2HeaderBytes));
  }

  std::array<unsigned char, kHeaderBytes> bytes_{};
  bool swap_ = false;
};

PixelType pixel_type(const std::string& path, const NiftiHeader& header) {
  switch (header.datatype()) {
    case 2:
      return PixelType::uint8;
    case 4:
      return PixelType::int16;
    case 8:
      return PixelType::int32;
    case 16:
      return PixelType::float32;
    case 64:
      return PixelType::float64;
    case 256:
      return PixelType::int8;
    case 512:
      return PixelType::uint16;
    case 768:
      return PixelType::uint32;
    case 1024:
      return PixelType::int64;
    case 1280:
      return PixelType::uint64;
    default:
      throw_bad_input(path, "its voxels are not scalar numbers of 8 to 64 bits",
                      "write one label map");
  }
}

void check_dimensions(const std::string& path, const NiftiHeader& header) {
  const int dimensions = header.dimension(0);
  if (dimensions < 2 || dimensions > 7) {
    throw_bad_input(path, "it is not a 3D volume", "give a 3D segmentation");
  }
  for (int i = 1; i <= dimensions; ++i) {
    if (header.dimension(i) < 1)
      throw_bad_input(path, "its size is below one voxel", "write the volume again");
    if (i > 3 && header.dimension(i) > 1) {
      throw_bad_input(path,
                      i == 4 ? "it is a series in time, not one volume"
                             : "its voxels have several components each, not one",
                      "extract the volume to convert");
    }
    if (i <= 3) check_raw_spacing(path, header.pixdim(i));
  }
}

// Where the sform alone places the volume, its columns must be pixdim times orthonormal vectors.
void check_sform(const std::string& path, const NiftiHeader& header) {
  constexpr double kTolerance = 1e-3;
  if (header.has_qform() || !header.has_sform() || header.dimension(0) < 3) return;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      double dot = 0;
      for (int row = 0; row < 3; ++row) dot += header.sform(row, a) * header.sform(row, b);
      dot /= header.pixdim(a + 1) * header.pixdim(b + 1);
      if (std::abs(dot - (a == b ? 1 : 0)) <= (a == b ? 2 : 1) * kTolerance) continue;
      throw_bad_input(path,
                      a == b ? "its sform and its spacing (pixdim) disagree"
                             : "its sform is sheared: its axes are not at right angles",
                      a == b ? "correct its header" : "resample the volume on orthogonal axes");
    }
  }
}

void set_rescaling(const NiftiHeader& header, PixelLayout& layout) {
  if (!std::isfinite(header.slope()) || header.slope() == 0) return;
  layout.slope = header.slope();
  layout.intercept = std::isfinite(header.intercept()) ? header.intercept() : 0;
}

}  // namespace

Volume open_nifti(const std::string& path) {
  const bool compressed = file_ending(path, {".gz"}) == ".gz";
  const Encoding encoding = compressed ? Encoding::deflate : Encoding::raw;
  const NiftiHeader header(path, encoding);
  check_dimensions(path, header);
  check_sform(path, header);
  PixelLayout layout{.file = path, .encoding = encoding, .type = pixel_type(path, header)};
  layout.swap_bytes = header.swapped();
  set_rescaling(header, layout);
  if (!(header.voxel_offset() >= kHeaderBytes && header.voxel_offset() < 1e15)) {
    throw_bad_input(path, "its voxels lie at an impossible offset", "write the volume again");
  }
  layout.skip = static_cast<std::int64_t>(header.voxel_offset());

  auto io = itk::NiftiImageIO::New();
  Volume volume;
  layout.count = 1;
  for (int i = 1; i <= std::min(header.dimension(0), 3); ++i) layout.count *= header.dimension(i);
  volume.pixels = make_file_pixels(path, layout);
  read_itk_header(path, *io);
  volume.geometry = itk_geometry(path, *io);
  return volume;
}

}  // namespace vasamesh

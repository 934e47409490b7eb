#include "io/volume_reader.h"

#include <bit>
#include <filesystem>
#include <memory>
#include <new>
#include <system_error>
#include <utility>

#include "io/bit_rows.h"
#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/memory_limit.h"
#include "io/quiet.h"
#include "io/selection.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

Volume open_volume(const std::string& path, const ReadOptions& options) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return open_dicom_series(path, options);
  file_size(path);
  const std::string ending = file_ending(path, {".nii", ".nii.gz", ".mha", ".mhd", ".nrrd"});
  if (ending == ".nii" || ending == ".nii.gz") return open_nifti(path);
  if (ending == ".mha" || ending == ".mhd") return open_meta(path);
  if (ending == ".nrrd") return open_nrrd(path);
  throw_bad_input(path, "unknown format of a volume",
                  "give .nii, .nii.gz, .mha, .mhd, .nrrd or a folder with a DICOM series");
}

/// Pixels that come to an end when they are told to.
class CancellablePixels final : public PixelSource {
 public:
  CancellablePixels(std::unique_ptr<PixelSource> pixels, const std::atomic<bool>& cancel)
      : pixels_(std::move(pixels)), cancel_(cancel) {}

  void visit(const ChunkVisitor& visitor) const override {
    pixels_->visit([&](const PixelChunk& chunk) {
      if (cancel_) throw Error(ErrorCode::cancelled, "cancelled during read");
      visitor(chunk);
    });
  }

 private:
  std::unique_ptr<PixelSource> pixels_;
  const std::atomic<bool>& cancel_;
};

/// What the voxels take; their count is possible.
std::int64_t bytes_of(const std::array<std::int64_t, 3>& size, VoxelFormat format) {
  const auto row = static_cast<std::size_t>(size[0]);
  return static_cast<std::int64_t>(format == VoxelFormat::bits ? bit_row_bytes(row) : row) *
         size[1] * size[2];
}

/// \param format  what the caller will hold, for the limit of memory.
PackedSegmentation read(const std::string& path, const ReadOptions& options, VoxelFormat format) {
  Volume volume = open_volume(path, options);
  voxel_count(path, volume.geometry);
  check_geometry(path, volume.geometry);
  const auto& size = volume.geometry.size;
  check_memory(path, bytes_of(size, format), options);
  if (options.cancel)
    volume.pixels = std::make_unique<CancellablePixels>(std::move(volume.pixels), *options.cancel);
  return {volume.geometry, select_object(path, *volume.pixels, size, options)};
}

Segmentation unpacked(const PackedSegmentation& packed) {
  const auto length = static_cast<std::size_t>(packed.geometry.size[0]);
  const std::size_t row_bytes = bit_row_bytes(length), rows = packed.bits.size() / row_bytes;
  Segmentation segmentation{packed.geometry, std::vector<std::uint8_t>(length * rows)};
  for (std::size_t byte = 0; byte < packed.bits.size(); ++byte) {
    std::uint8_t* voxels = &segmentation.voxels[byte / row_bytes * length + byte % row_bytes * 8];
    for (unsigned bits = packed.bits[byte]; bits != 0; bits &= bits - 1)
      voxels[std::countr_zero(bits)] = 1;
  }
  return segmentation;
}

/// Runs `work`, and turns what is not ours into our errors.
template <class Work>
auto guarded(const std::string& path, const Work& work) {
  const Quiet quiet;
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw_refused(path, "not enough memory to read it", "crop the volume");
  } catch (const itk::ExceptionObject&) {
    throw_bad_input(path, "it cannot be read", "write the volume again");
  }
}

}  // namespace

std::string voxel_file(const std::string& path) {
  try {
    file_size(path);
    const std::string ending = file_ending(path, {".mha", ".mhd", ".nrrd"});
    const std::string file = ending.empty()      ? path
                             : ending == ".nrrd" ? nrrd_voxel_file(path)
                                                 : meta_voxel_file(path);
    return file == path ? "" : file;
  } catch (const Error&) {
    return {};  // reading will say what is wrong
  }
}

PackedSegmentation read_packed(const std::string& path, const ReadOptions& options) {
  return guarded(path, [&] { return read(path, options, VoxelFormat::bits); });
}

Segmentation read_segmentation(const std::string& path, const ReadOptions& options) {
  return guarded(path, [&] { return unpacked(read(path, options, VoxelFormat::bytes)); });
}

}  // namespace vasamesh

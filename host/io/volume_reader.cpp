#include "io/volume_reader.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <new>
#include <system_error>
#include <utility>

#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/quiet.h"
#include "io/selection.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

Volume open_volume(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return open_dicom_series(path);
  file_size(path);
  const std::string ending = file_ending(path, {".nii", ".nii.gz", ".mha", ".mhd", ".nrrd"});
  if (ending == ".nii" || ending == ".nii.gz") return open_nifti(path);
  if (ending == ".mha" || ending == ".mhd") return open_meta(path);
  if (ending == ".nrrd") return open_nrrd(path);
  throw_bad_input(path, "unknown format of a volume",
                  "give .nii, .nii.gz, .mha, .mhd, .nrrd or a folder with a DICOM series");
}

std::int64_t machine_memory() {
  return static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
}

void check_memory(const std::string& path, std::int64_t bytes, const ReadOptions& options) {
  const std::int64_t limit = options.max_memory > 0 ? options.max_memory : machine_memory();
  if (bytes <= limit) return;
  throw_refused(
      path, fmt::format("it needs {} bytes of memory, {} are allowed", bytes, limit),
      options.max_memory > 0 ? "raise --max-memory or crop the volume" : "crop the volume");
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

Segmentation read(const std::string& path, const ReadOptions& options) {
  Volume volume = open_volume(path);
  const std::int64_t count = voxel_count(path, volume.geometry);
  check_geometry(path, volume.geometry);
  check_memory(path, count, options);
  if (options.cancel)
    volume.pixels = std::make_unique<CancellablePixels>(std::move(volume.pixels), *options.cancel);
  return {volume.geometry,
          select_object(path, *volume.pixels, static_cast<std::size_t>(count), options)};
}

}  // namespace

Segmentation read_segmentation(const std::string& path, const ReadOptions& options) {
  const Quiet quiet;
  try {
    return read(path, options);
  } catch (const std::bad_alloc&) {
    throw_refused(path, "not enough memory to read it", "crop the volume");
  } catch (const itk::ExceptionObject&) {
    throw_bad_input(path, "it cannot be read", "write the volume again");
  }
}

}  // namespace vasamesh

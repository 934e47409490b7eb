/// \file
/// A folder with one DICOM series: slices, a file each, or files of several frames. The headers say
/// where they lie (dicom_stack.h), ITK and GDCM decode the pixels.
/// Debian's GDCM is built with assertions, which corrupt files trip: all is read on trial first.

#include <itkGDCMImageIO.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "io/byte_stream.h"
#include "io/dicom_folder.h"
#include "io/dicom_stack.h"
#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/trial.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

// GDCM fills the end of a truncated slice with zeros in silence.
void check_whole(const DicomFile& file) {
  if (!file.is_raw) return;
  const double bits = static_cast<double>(file.columns * file.rows) *
                      static_cast<double>(file.frame_count) *
                      static_cast<double>(file.samples * file.bits_allocated);
  if (static_cast<double>(file_size(file.path) - file.pixels_begin) < std::ceil(bits / 8))
    throw_bad_input(file.path, "truncated", "get a whole copy of the series");
}

/// Pixels frame by frame, as float64: files may differ in type, by their rescaling.
class DicomPixels final : public PixelSource {
 public:
  /// \param slices  [file][frame]: which slice of the volume.
  DicomPixels(std::vector<DicomFile> files, std::vector<std::vector<std::size_t>> slices)
      : files_(std::move(files)), slices_(std::move(slices)) {}

  void visit(const ChunkVisitor& visitor) const override {
    for (std::size_t i = 0; i < files_.size(); ++i) visit_file(files_[i], slices_[i], visitor);
  }

 private:
  static void visit_file(const DicomFile& file, const std::vector<std::size_t>& slices,
                         const ChunkVisitor& visitor) {
    auto io = itk::GDCMImageIO::New();
    read_itk_header(file.path, *io);
    const PixelType type = itk_pixel_type(file.path, *io);
    const std::vector<unsigned char> bytes = decoded(file, *io, pixel_bytes(type));
    std::vector<double> values(static_cast<std::size_t>(file.columns * file.rows));
    visit_pixel_type(type, [&]<class T>(T) {
      const T* pixels = reinterpret_cast<const T*>(bytes.data());
      for (const std::size_t slice : slices) {
        for (double& value : values) value = static_cast<double>(*pixels++);
        visitor({slice * values.size(), values.size(), PixelType::float64, values.data()});
      }
    });
  }

  static std::vector<unsigned char> decoded(const DicomFile& file, itk::GDCMImageIO& io,
                                            std::size_t size) {
    const std::int64_t pixels = file.columns * file.rows * file.frame_count;
    if (static_cast<std::int64_t>(io.GetImageSizeInPixels()) != pixels) throw_corrupt(file);
    std::vector<unsigned char> bytes(static_cast<std::size_t>(pixels) * size);
    try {
      io.Read(bytes.data());
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception&) {
      throw_corrupt(file);
    }
    return bytes;
  }

  [[noreturn]] static void throw_corrupt(const DicomFile& file) {
    throw_bad_input(file.path, "truncated or corrupt", "get a whole copy of the series");
  }

  std::vector<DicomFile> files_;
  std::vector<std::vector<std::size_t>> slices_;
};

Volume open_series(const std::string& folder, const std::vector<std::string>& paths) {
  std::vector<DicomFile> files = dicom_series(folder, paths);
  DicomStack stack = dicom_stack(files);
  for (const DicomFile& file : files) check_whole(file);
  voxel_count(folder, stack.geometry);
  return {stack.geometry, std::make_unique<DicomPixels>(std::move(files), std::move(stack.slices))};
}

/// The memory that reading may take on trial.
std::int64_t memory_for(const std::vector<std::string>& files) {
  std::int64_t bytes = 0;
  for (const std::string& file : files) bytes += file_size(file);
  return reading_memory(bytes);
}

/// Names the file that no trial survives.
[[noreturn]] void throw_culprit(const std::string& folder, const std::vector<std::string>& files) {
  for (const std::string& file : files)
    if (!survives(memory_for({file}), [&] { read_dicom_file(file); })) throw_damaged_header(file);
  throw_bad_input(folder, "a file in it is corrupt", "get a whole copy of the series");
}

}  // namespace

Volume open_dicom_series(const std::string& folder) {
  const std::vector<std::string> files = list_dicom_folder(folder);
  const auto read_all = [&] { open_series(folder, files).pixels->visit([](const PixelChunk&) {}); };
  if (!survives(memory_for(files), read_all)) throw_culprit(folder, files);
  return open_series(folder, files);
}

}  // namespace vasamesh

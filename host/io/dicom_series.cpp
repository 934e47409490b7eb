/// \file
/// A folder with one DICOM series: slices, a file each, or files of several frames. The headers say
/// where they lie (dicom_stack.h), ITK and GDCM decode the pixels.
/// Debian's GDCM is built with assertions, which corrupt files trip: all is read on trial first.

#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "io/byte_stream.h"
#include "io/dicom_folder.h"
#include "io/dicom_stack.h"
#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/memory_limit.h"
#include "io/trial.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

std::int64_t bytes_of(double bytes) {
  return static_cast<std::int64_t>(std::min(std::ceil(bytes), 0x1p62));
}

double pixel_count(const DicomFile& file) {
  return static_cast<double>(file.columns * file.rows) * static_cast<double>(file.frame_count);
}

/// The voxels as the header states them.
std::int64_t voxel_bytes(const DicomFile& file) {
  return bytes_of(pixel_count(file) * static_cast<double>(file.samples * file.bits_allocated) / 8);
}

/// The most that ITK, GDCM and DicomPixels take to decode the file: some copies of its bytes and of
/// its voxels, and the voxels once more, rescaled.
std::int64_t decoding_bytes(const DicomFile& file) {
  return bytes_of(2 * static_cast<double>(file_size(file.path)) +
                  6 * static_cast<double>(voxel_bytes(file)) + 8 * pixel_count(file));
}

// GDCM fills the end of a truncated slice with zeros in silence.
void check_pixels(const DicomFile& file) {
  if (file.bits_allocated == 1 && (!file.is_raw || file.is_big_endian || file.samples != 1))
    throw_bad_input(file.path,
                    "voxels of 1 bit that are compressed or big-endian are not supported",
                    "write them as 8-bit, or as NIfTI or NRRD");
  if (file.is_raw && file_size(file.path) - file.pixels_begin < voxel_bytes(file))
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
    if (file.bits_allocated == 1) return visit_bits(file, slices, visitor);
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

  /// Frames follow each other without a gap, least significant bit first (PS3.5, 8.1.1); GDCM gives
  /// no value to those after the last whole byte.
  static void visit_bits(const DicomFile& file, const std::vector<std::size_t>& slices,
                         const ChunkVisitor& visitor) {
    std::vector<unsigned char> bytes(static_cast<std::size_t>(voxel_bytes(file)));
    ByteStream(file.path, file.pixels_begin, Encoding::raw).read(bytes.data(), bytes.size());
    std::vector<double> values(static_cast<std::size_t>(file.columns * file.rows));
    std::size_t bit = 0;
    for (const std::size_t slice : slices) {
      for (double& value : values) {
        value = bytes[bit / 8] >> bit % 8 & 1;
        ++bit;
      }
      visitor({slice * values.size(), values.size(), PixelType::float64, values.data()});
    }
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

  /// GDCM takes a lack of memory for a fault of the file.
  [[noreturn]] static void throw_corrupt(const DicomFile& file) {
    if (memory_left() < decoding_bytes(file)) throw std::bad_alloc();
    throw_bad_input(file.path, "truncated or corrupt", "get a whole copy of the series");
  }

  std::vector<DicomFile> files_;
  std::vector<std::vector<std::size_t>> slices_;
};

/// A series whose headers have been read.
struct Series {
  std::vector<DicomFile> files;
  DicomStack stack;
};

Series read_headers(const std::string& folder, const std::vector<std::string>& paths) {
  Series series{dicom_series(folder, paths), {}};
  series.stack = dicom_stack(series.files);
  for (const DicomFile& file : series.files) check_pixels(file);
  return series;
}

/// The memory, and with it the time, that reading may take on trial.
std::int64_t memory_for(const std::vector<std::string>& paths) {
  std::int64_t bytes = 0;
  for (const std::string& path : paths) bytes += file_size(path);
  return reading_memory(bytes);
}

/// Reads the headers, on trial first.
Series try_headers(const std::string& folder, const std::vector<std::string>& paths) {
  const std::int64_t memory = memory_for(paths);
  if (survives(memory, [&] { read_headers(folder, paths); })) return read_headers(folder, paths);
  for (const std::string& path : paths)
    if (!survives(memory, [&] { read_dicom_file(path); })) throw_damaged_header(path);
  throw_bad_input(folder, "a file in it is corrupt", "get a whole copy of the series");
}

/// Decodes all pixels on trial.
void try_pixels(const std::string& folder, const Series& series, std::int64_t memory) {
  const auto visit = [](const DicomPixels& pixels) { pixels.visit([](const PixelChunk&) {}); };
  std::int64_t decoding = 0;
  for (const DicomFile& file : series.files) decoding = std::max(decoding, decoding_bytes(file));
  memory += decoding;
  if (survives(memory, [&] { visit({series.files, series.stack.slices}); })) return;
  if (memory_left() < decoding) throw std::bad_alloc();
  for (std::size_t i = 0; i < series.files.size(); ++i)
    if (!survives(memory, [&] { visit({{series.files[i]}, {series.stack.slices[i]}}); }))
      throw_bad_input(series.files[i].path, "corrupt", "get a whole copy of the series");
  throw_bad_input(folder, "a file in it is corrupt", "get a whole copy of the series");
}

}  // namespace

Volume open_dicom_series(const std::string& folder, const ReadOptions& options) {
  const std::vector<std::string> paths = list_dicom_folder(folder);
  Series series = try_headers(folder, paths);
  for (const DicomFile& file : series.files) check_memory(file.path, voxel_bytes(file), options);
  voxel_count(folder, series.stack.geometry);
  try_pixels(folder, series, memory_for(paths));
  return {series.stack.geometry,
          std::make_unique<DicomPixels>(std::move(series.files), std::move(series.stack.slices))};
}

}  // namespace vasamesh

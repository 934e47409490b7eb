/// \file
/// A folder with one DICOM series (DICOM PS3.3, C.7.6.2: image plane). GDCM reads the slices, which
/// are ordered along their normal; the spacing between them is measured from their positions, and
/// must be even.
/// Debian's GDCM is built with assertions, which corrupt files trip: all is read on trial first.

#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "io/byte_stream.h"
#include "io/dicom_folder.h"
#include "io/io_error.h"
#include "io/itk_header.h"
#include "io/trial.h"
#include "io/volume_formats.h"

namespace vasamesh {
namespace {

using Vector = std::array<double, 3>;

Vector column(const Geometry& geometry, int axis) {
  return {geometry.direction[axis], geometry.direction[3 + axis], geometry.direction[6 + axis]};
}

Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

void set_slice_axis(const Vector& axis, Geometry& geometry) {
  for (int row = 0; row < 3; ++row) geometry.direction[3 * row + 2] = axis[row];
}

// GDCM fills the end of a truncated slice with zeros in silence.
void check_whole(const DicomFile& file) {
  if (!file.is_raw) return;
  const double bits = static_cast<double>(file.columns * file.rows) *
                      static_cast<double>(file.frame_count * file.samples * file.bits_allocated);
  if (static_cast<double>(file_size(file.path) - file.pixels_begin) < std::ceil(bits / 8))
    throw_bad_input(file.path, "truncated", "get a whole copy of the series");
}

/// Pixels slice by slice, as float64: slices may differ in type, by their rescaling.
class DicomPixels final : public PixelSource {
 public:
  DicomPixels(std::string folder, std::vector<std::string> files, std::size_t file_pixels)
      : folder_(std::move(folder)), files_(std::move(files)), file_pixels_(file_pixels) {}

  void visit(const ChunkVisitor& visitor) const override {
    std::vector<double> values(file_pixels_);
    for (std::size_t i = 0; i < files_.size(); ++i) {
      read_file(files_[i], values);
      visitor({i * file_pixels_, file_pixels_, PixelType::float64, values.data()});
    }
  }

 private:
  void read_file(const std::string& file, std::vector<double>& values) const {
    auto io = itk::GDCMImageIO::New();
    read_itk_header(file, *io);
    const PixelType type = itk_pixel_type(file, *io);
    if (static_cast<std::size_t>(io->GetImageSizeInPixels()) != file_pixels_) {
      throw_bad_input(folder_, "its slices differ in size", "keep one series in the folder");
    }
    std::vector<unsigned char> bytes(file_pixels_ * pixel_bytes(type));
    try {
      io->Read(bytes.data());
    } catch (const std::exception&) {
      throw_bad_input(file, "truncated or corrupt", "get a whole copy of the series");
    }
    visit_pixel_type(type, [&]<class T>(T) {
      const T* pixels = reinterpret_cast<const T*>(bytes.data());
      for (std::size_t i = 0; i < file_pixels_; ++i) values[i] = static_cast<double>(pixels[i]);
    });
  }

  std::string folder_;
  std::vector<std::string> files_;
  std::size_t file_pixels_;
};

/// What the slice says of itself; 0: nothing.
double slice_thickness(const itk::GDCMImageIO& io) {
  std::string text;
  itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), "0018|0050", text);
  return std::strtod(text.c_str(), nullptr);
}

Geometry slice_geometry(const std::string& file) {
  auto io = itk::GDCMImageIO::New();
  read_itk_header(file, *io);
  itk_pixel_type(file, *io);
  Geometry geometry = itk_geometry(file, *io);
  const double thickness = slice_thickness(*io);
  if (geometry.size[2] == 1 && thickness > 0) geometry.spacing[2] = thickness;
  return geometry;
}

void check_same_plane(const std::string& folder, const Geometry& first, const Geometry& slice) {
  bool same = first.size == slice.size;
  for (int i = 0; i < 9; ++i) same &= std::abs(first.direction[i] - slice.direction[i]) < 1e-3;
  for (int i = 0; i < 2; ++i) {
    same &= std::abs(first.spacing[i] - slice.spacing[i]) < 1e-3 * first.spacing[i];
  }
  if (same) return;
  throw_bad_input(folder, "its slices differ in size, spacing or orientation",
                  "keep one series in the folder");
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Slice {
  std::string file;
  Geometry geometry;
  double depth = 0;  ///< along the normal of the first
};

/// Along the normal, from each slice to the next.
void check_steps(const std::vector<Slice>& slices) {
  constexpr double kTolerance = 0.1;
  std::vector<double> steps;
  for (std::size_t i = 1; i < slices.size(); ++i)
    steps.push_back(slices[i].depth - slices[i - 1].depth);
  const double usual = median(steps);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (std::abs(steps[i] - usual) <= kTolerance * usual) continue;
    throw_bad_input(slices[i + 1].file,
                    fmt::format("this slice is {:.6g} mm from the one before, others {:.6g} mm",
                                steps[i], usual),
                    "give every slice once");
  }
}

/// In order along their normal.
std::vector<Slice> slices_of(const std::string& folder, const std::vector<DicomFile>& files) {
  std::vector<Slice> slices;
  for (const DicomFile& file : files) slices.push_back({file.path, slice_geometry(file.path)});
  const Geometry first = slices.front().geometry;
  const Vector normal = cross(column(first, 0), column(first, 1));
  for (Slice& slice : slices) {
    check_same_plane(folder, first, slice.geometry);
    slice.depth = dot(slice.geometry.origin, normal);
  }
  std::stable_sort(slices.begin(), slices.end(),
                   [](const Slice& a, const Slice& b) { return a.depth < b.depth; });
  return slices;
}

/// Sizes, spacing and direction of the stack of slices.
Geometry stack_geometry(const std::vector<Slice>& slices) {
  Geometry stack = slices.front().geometry;
  if (slices.size() == 1) return stack;
  check_steps(slices);
  const Vector way = difference(slices.back().geometry.origin, slices.front().geometry.origin);
  const auto steps = static_cast<double>(slices.size() - 1);
  stack.size[2] = static_cast<std::int64_t>(slices.size());
  stack.spacing[2] = (slices.back().depth - slices.front().depth) / steps;
  const double length = std::sqrt(dot(way, way));
  set_slice_axis({way[0] / length, way[1] / length, way[2] / length}, stack);
  return stack;
}

Volume open_series(const std::string& folder, const std::vector<DicomFile>& files) {
  for (const DicomFile& file : files) check_whole(file);
  const std::vector<Slice> slices = slices_of(folder, files);
  std::vector<std::string> paths;
  for (const Slice& slice : slices) paths.push_back(slice.file);
  Volume volume;
  volume.geometry = stack_geometry(slices);
  const auto pixels = static_cast<std::size_t>(voxel_count(folder, volume.geometry));
  volume.pixels = std::make_unique<DicomPixels>(folder, paths, pixels / slices.size());
  return volume;
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
  const auto read_all = [&] {
    open_series(folder, dicom_series(folder, files)).pixels->visit([](const PixelChunk&) {});
  };
  if (!survives(memory_for(files), read_all)) throw_culprit(folder, files);
  return open_series(folder, dicom_series(folder, files));
}

}  // namespace vasamesh

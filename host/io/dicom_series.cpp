/// \file
/// A folder with one DICOM series (DICOM PS3.3, C.7.6.2: image plane). GDCM reads the slices and
/// orders them; the spacing between slices is measured from their positions, and must be even.
/// Debian's GDCM is built with assertions, which corrupt files trip: all is read on trial first.

#include <fmt/format.h>
#include <gdcmImageHelper.h>
#include <gdcmReader.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <vector>

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

std::int64_t folder_bytes(const std::string& folder) {
  std::int64_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += static_cast<std::int64_t>(entry.file_size());
  }
  return bytes;
}

/// The files of the only series in `folder`, in order of their positions.
std::vector<std::string> series_files(const std::string& folder) {
  auto names = itk::GDCMSeriesFileNames::New();
  names->SetUseSeriesDetails(true);
  names->SetInputDirectory(folder);
  const std::vector<std::string> series = names->GetSeriesUIDs();
  if (series.empty()) {
    throw_bad_input(folder, "a folder without a DICOM series", "give a file, or such a folder");
  }
  if (series.size() > 1) {
    std::string list;
    for (std::size_t i = 0; i < series.size() && i < 10; ++i) list += (i ? ", " : "") + series[i];
    throw_bad_input(folder,
                    fmt::format("it holds {} DICOM series ({}{})", series.size(), list,
                                series.size() > 10 ? ", ..." : ""),
                    "put the one to convert into a folder of its own");
  }
  return names->GetFileNames(series.front());
}

// GDCM fills the end of a truncated slice with zeros in silence.
void check_whole(const std::string& file) {
  const gdcm::Tag pixels(0x7fe0, 0x0010);
  gdcm::Reader reader;
  reader.SetFileName(file.c_str());
  if (!reader.ReadUpToTag(pixels, {pixels}) ||
      reader.GetFile().GetHeader().GetDataSetTransferSyntax().IsEncapsulated()) {
    return;
  }
  double bytes = gdcm::ImageHelper::GetPixelFormatValue(reader.GetFile()).GetPixelSize();
  for (const unsigned size : gdcm::ImageHelper::GetDimensionsValue(reader.GetFile())) {
    bytes *= size;
  }
  const auto begin = static_cast<std::int64_t>(reader.GetStreamCurrentPosition());
  if (static_cast<double>(file_size(file) - begin) < bytes) {
    throw_bad_input(file, "truncated", "get a whole copy of the series");
  }
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
    check_whole(file);
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

/// \param steps  from each slice to the next; steps[i] leads to files[i + 1].
void check_steps(const std::vector<std::string>& files, const std::vector<double>& steps) {
  constexpr double kTolerance = 0.1;
  const double usual = median(steps);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (std::abs(steps[i] - usual) <= kTolerance * std::abs(usual)) continue;
    throw_bad_input(files[i + 1],
                    fmt::format("this slice is {:.6g} mm from the one before, others {:.6g} mm",
                                std::abs(steps[i]), std::abs(usual)),
                    "give every slice once");
  }
}

/// Sizes, spacing and direction of the stack of slices.
Geometry stack_geometry(const std::string& folder, const std::vector<std::string>& files) {
  Geometry stack = slice_geometry(files.front());
  const Vector normal = cross(column(stack, 0), column(stack, 1));
  std::vector<Vector> positions{stack.origin};
  for (std::size_t i = 1; i < files.size(); ++i) {
    const Geometry slice = slice_geometry(files[i]);
    check_same_plane(folder, stack, slice);
    positions.push_back(slice.origin);
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < files.size(); ++i) {
    steps.push_back(dot(difference(positions[i], positions[i - 1]), normal));
  }
  check_steps(files, steps);
  const Vector way = difference(positions.back(), positions.front());
  stack.size[2] = static_cast<std::int64_t>(files.size());
  stack.spacing[2] = std::abs(dot(way, normal)) / static_cast<double>(steps.size());
  const double length = std::sqrt(dot(way, way));
  set_slice_axis({way[0] / length, way[1] / length, way[2] / length}, stack);
  return stack;
}

Volume open_series(const std::string& folder) {
  const std::vector<std::string> files = series_files(folder);
  Volume volume;
  volume.geometry =
      files.size() == 1 ? slice_geometry(files.front()) : stack_geometry(folder, files);
  const auto pixels = static_cast<std::size_t>(voxel_count(folder, volume.geometry));
  volume.pixels = std::make_unique<DicomPixels>(folder, files, pixels / files.size());
  return volume;
}

}  // namespace

Volume open_dicom_series(const std::string& folder) {
  const auto read_all = [&] { open_series(folder).pixels->visit([](const PixelChunk&) {}); };
  if (!survives(reading_memory(folder_bytes(folder)), read_all)) {
    throw_bad_input(folder, "a file in it is corrupt", "get a whole copy of the series");
  }
  return open_series(folder);
}

}  // namespace vasamesh

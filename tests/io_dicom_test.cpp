/// \file
/// DICOM series: written through ITK and GDCM, then read from their folder.

#include <gdcmTrace.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImageSeriesWriter.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>

#include "io/volume_reader.h"
#include "support/itk_volumes.h"
#include "support/scratch.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using ::testing::HasSubstr;

/// Slices of a rotated volume with 0.7 x 0.7 x 1.25 mm voxels.
Geometry series_geometry(bool mirrored) {
  const double c = std::cos(0.4), s = std::sin(0.4), z = mirrored ? -1 : 1;
  return {{21, 17, 6}, {0.7, 0.7, 1.25}, {-30, 12.5, 200}, {c, -s, 0, s, c, 0, 0, 0, z}};
}

std::vector<std::int16_t> random_pixels(const Geometry& geometry, std::int16_t object) {
  std::mt19937 random(5);
  std::vector<std::int16_t> pixels(
      static_cast<std::size_t>(geometry.size[0] * geometry.size[1] * geometry.size[2]));
  for (auto& pixel : pixels) pixel = random() % 3 == 0 ? object : std::int16_t{0};
  return pixels;
}

/// Decimal strings, as DICOM separates them.
template <std::size_t N>
std::string decimals(const std::array<double, N>& values) {
  std::string text;
  for (const double value : values) {
    char digits[32];
    std::snprintf(digits, sizeof(digits), "%.9g", value);
    if (!text.empty()) text += '\\';
    text += digits;
  }
  return text;
}

/// The tags that place slice k of a series.
itk::MetaDataDictionary slice_tags(const Geometry& geometry, int k, const std::string& series) {
  std::array<double, 3> position;
  std::array<double, 6> orientation;
  for (int row = 0; row < 3; ++row) {
    position[row] =
        geometry.origin[row] + k * geometry.spacing[2] * geometry.direction[3 * row + 2];
    orientation[row] = geometry.direction[3 * row];
    orientation[3 + row] = geometry.direction[3 * row + 1];
  }
  itk::MetaDataDictionary tags;
  itk::EncapsulateMetaData<std::string>(tags, "0008|0060", "CT");
  itk::EncapsulateMetaData<std::string>(tags, "0018|0050", "2.5");  // thicker than far apart
  itk::EncapsulateMetaData<std::string>(tags, "0020|000d", "1.2.826.0.1.3680043.2.1");
  itk::EncapsulateMetaData<std::string>(tags, "0020|000e", "1.2.826.0.1.3680043.2." + series);
  itk::EncapsulateMetaData<std::string>(tags, "0020|0013", std::to_string(k + 1));
  itk::EncapsulateMetaData<std::string>(tags, "0020|0032", decimals(position));
  itk::EncapsulateMetaData<std::string>(tags, "0020|0037", decimals(orientation));
  return tags;
}

/// Writes a series into `folder`; the names of the files do not follow the positions.
void write_series(const std::string& folder, const Geometry& geometry,
                  const std::vector<std::int16_t>& pixels, const std::string& series) {
  using Image = itk::Image<std::int16_t, 3>;
  using Slice = itk::Image<std::int16_t, 2>;
  gdcm::Trace::WarningOff();
  std::filesystem::create_directories(folder);
  std::vector<std::string> names;
  std::vector<itk::MetaDataDictionary> tags;
  const int slices = static_cast<int>(geometry.size[2]);
  for (int k = 0; k < slices; ++k) {
    names.push_back(folder + "/" + series + "_" + std::to_string((k * 5 + 3) % slices) + ".dcm");
    tags.push_back(slice_tags(geometry, k, series));
  }
  std::vector<itk::MetaDataDictionary*> pointers;
  for (auto& tag : tags) pointers.push_back(&tag);
  auto io = itk::GDCMImageIO::New();
  io->KeepOriginalUIDOn();
  auto writer = itk::ImageSeriesWriter<Image, Slice>::New();
  writer->SetInput(make_itk_image(geometry, pixels));
  writer->SetImageIO(io);
  writer->SetFileNames(names);
  writer->SetMetaDataDictionaryArray(&pointers);
  writer->Update();
}

std::string error_of(const std::string& path) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  std::string message = "no error";
  try {
    read_segmentation(path);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    message = error.what();
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  return message;
}

TEST(Dicom, SeriesIsReadInOrderAndPlace) {
  for (const bool mirrored : {false, true}) {
    SCOPED_TRACE(mirrored);
    const Scratch scratch;
    const Geometry geometry = series_geometry(mirrored);
    const auto pixels = random_pixels(geometry, 900);
    write_series(scratch / "series", geometry, pixels, "7");
    write_text(scratch / "series/readme.txt", "not a slice");
    Segmentation read = read_segmentation(scratch / "series");
    // GDCM orders slices along the normal of their plane: a mirrored stack comes turned round.
    const bool turned = mirrored;
    std::array<double, 3> first = geometry.origin;
    if (turned) first[2] += 5 * 1.25 * geometry.direction[8];
    EXPECT_EQ(read.geometry.size, geometry.size);
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(read.geometry.spacing[a], geometry.spacing[a], 1e-6);
      EXPECT_NEAR(read.geometry.origin[a], first[a], 1e-6);
      for (int b = 0; b < 3; ++b) {
        const double wanted = geometry.direction[3 * b + a] * (turned && a == 2 ? -1 : 1);
        EXPECT_NEAR(read.geometry.direction[3 * b + a], wanted, 1e-6);
      }
    }
    const std::size_t slice = 21 * 17;
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t from = slice * (turned ? 5 - k : k);
      for (std::size_t i = 0; i < slice; ++i) {
        ASSERT_EQ(read.voxels[k * slice + i], pixels[from + i] != 0) << k << " " << i;
      }
    }
  }
}

TEST(Dicom, OneSlice) {
  const Scratch scratch;
  Geometry geometry = series_geometry(false);
  geometry.size[2] = 1;
  const auto pixels = random_pixels(geometry, 1);
  write_series(scratch / "series", geometry, pixels, "7");
  const Segmentation read = read_segmentation(scratch / "series");
  EXPECT_EQ(read.geometry.size, geometry.size);
  EXPECT_EQ(read.geometry.spacing[2], 2.5);
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), read.voxels.begin(), read.voxels.end()));
}

TEST(Dicom, SeveralSeriesAreNamed) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "8");
  const std::string message = error_of(scratch / "series");
  EXPECT_THAT(message, HasSubstr("2 DICOM series (1.2.826.0.1.3680043.2.7"));
  EXPECT_THAT(message, HasSubstr("1.2.826.0.1.3680043.2.8"));
  EXPECT_THAT(message, HasSubstr("a folder of its own"));
}

TEST(Dicom, MissingSlice) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  std::filesystem::remove(scratch / "series/7_0.dcm");
  const std::string message = error_of(scratch / "series");
  EXPECT_THAT(message, HasSubstr("this slice is 2.5 mm from the one before, others 1.25 mm"));
  EXPECT_THAT(message, HasSubstr("every slice once"));
}

TEST(Dicom, TruncatedSlice) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  const std::string bytes = read_text(scratch / "series/7_2.dcm");
  write_text(scratch / "series/7_2.dcm", bytes.substr(0, bytes.size() - 100));
  EXPECT_THAT(error_of(scratch / "series"), HasSubstr("7_2.dcm: truncated"));
}

TEST(Dicom, TiltedGantryIsSheared) {
  const Scratch scratch;
  Geometry geometry = series_geometry(false);
  geometry.direction[5] = 0.05;  // slices step sideways
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  EXPECT_THAT(error_of(scratch / "series"), HasSubstr("sheared"));
}

TEST(Dicom, GreyLevelsNeedAChoice) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  auto pixels = random_pixels(geometry, 1);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::int16_t>(i % 900);
  write_series(scratch / "series", geometry, pixels, "7");
  EXPECT_THAT(error_of(scratch / "series"), HasSubstr("values from 0 to 899"));
  const Segmentation read = read_segmentation(scratch / "series", {.threshold = 450});
  for (std::size_t i = 0; i < pixels.size(); ++i) ASSERT_EQ(read.voxels[i], pixels[i] >= 450) << i;
}

}  // namespace
}  // namespace vasamesh

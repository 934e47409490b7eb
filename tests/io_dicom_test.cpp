/// \file
/// DICOM series: how slices are ordered, placed and read.

#include <gdcmTransferSyntax.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "io/volume_reader.h"
#include "support/dicom_files.h"
#include "support/scratch.h"

namespace vasamesh {
namespace {

using ::testing::HasSubstr;

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

TEST(Dicom, MissingSlice) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  std::filesystem::remove(scratch / "series/7_0.dcm");
  const std::string message = dicom_error_of(scratch / "series");
  EXPECT_THAT(message, HasSubstr("this slice is 2.5 mm from the one before, others 1.25 mm"));
  EXPECT_THAT(message, HasSubstr("every slice once"));
}

TEST(Dicom, DeflatedSlices) {
  const Scratch scratch;
  const Geometry geometry = write_slices(scratch / "series");
  const auto pixels = random_pixels(geometry, 1);
  for (int k = 0; k < 6; ++k)
    edit_file(scratch / ("series/7_" + std::to_string(k) + ".dcm"), [](gdcm::File& file) {
      file.GetHeader().SetDataSetTransferSyntax(
          gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian);
    });
  const Segmentation read = read_segmentation(scratch / "series");
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), read.voxels.begin(), read.voxels.end()));
}

TEST(Dicom, DisplacedWithinThePlane) {
  for (const int k : {2, 5}) {
    const Scratch scratch;
    Geometry geometry = write_slices(scratch / "series");
    geometry.origin[0] += 3 * geometry.direction[0];
    geometry.origin[1] += 3 * geometry.direction[3];
    const std::string name = "7_" + std::to_string((k * 5 + 3) % 6) + ".dcm";
    geometry.origin[2] += 1.25 * k;
    set_decimals(scratch / ("series/" + name), kPosition, decimals(geometry.origin));
    EXPECT_THAT(dicom_error_of(scratch / "series"),
                HasSubstr(name + ": this slice is displaced by 3 mm within its plane"));
  }
}

TEST(Dicom, SlicesThatBendAway) {  // each by less than a tenth of the step
  const Scratch scratch;
  Geometry geometry = write_slices(scratch / "series");
  for (int k = 0; k < 6; ++k) {
    const std::string name = "series/7_" + std::to_string((k * 5 + 3) % 6) + ".dcm";
    set_decimals(scratch / name, kPosition, decimals(geometry.origin));
    geometry.origin[0] += k < 3 ? 0.1 : -0.1;
    geometry.origin[2] += 1.25;
  }
  EXPECT_THAT(dicom_error_of(scratch / "series"), HasSubstr("mm within its plane"));
}

TEST(Dicom, PixelSpacingMissingOrZero) {
  const Scratch scratch;
  const std::string folder = scratch / "series", slice = folder + "/7_2.dcm";
  write_slices(folder);
  edit(slice, [](gdcm::DataSet& set) { set.Remove(kSpacing); });
  EXPECT_THAT(dicom_error_of(folder),
              HasSubstr("7_2.dcm: it has no PixelSpacing (0028,0030); add it"));
  set_decimals(slice, gdcm::Tag(0x0018, 0x1164), "0.7\\0.7");
  EXPECT_THAT(dicom_error_of(folder),
              HasSubstr("7_2.dcm: it has no PixelSpacing (0028,0030), only Imager"));
  set_decimals(slice, kSpacing, "0\\0.7");
  EXPECT_THAT(dicom_error_of(folder),
              HasSubstr("its PixelSpacing (0028,0030) is 0 x 0.7 mm; correct it"));
}

TEST(Dicom, PositionsMissingOrTheSame) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  const Geometry geometry = write_slices(folder);
  edit(folder + "/7_2.dcm", [](gdcm::DataSet& set) { set.Remove(kPosition); });
  EXPECT_THAT(dicom_error_of(folder),
              HasSubstr("7_2.dcm: this slice has no position (ImagePosition"));
  for (int k = 0; k < 6; ++k)
    set_decimals(folder + "/7_" + std::to_string(k) + ".dcm", kPosition, decimals(geometry.origin));
  EXPECT_THAT(dicom_error_of(folder), HasSubstr("its slices have no positions of their own"));
  for (int k = 0; k < 5; ++k) std::filesystem::remove(folder + "/7_" + std::to_string(k) + ".dcm");
  edit(folder + "/7_5.dcm", [](gdcm::DataSet& set) { set.Remove(kPosition); });
  const Segmentation read = read_segmentation(folder);  // one slice lies anywhere
  EXPECT_EQ(read.geometry.size[2], 1);
  EXPECT_EQ(read.geometry.origin, (std::array<double, 3>{}));
}

TEST(Dicom, SliceThatIsThereTwice) {
  const Scratch scratch;
  write_slices(scratch / "series");
  std::filesystem::copy(scratch / "series/7_2.dcm", scratch / "series/copy.dcm");
  EXPECT_THAT(dicom_error_of(scratch / "series"),
              ::testing::AllOf(HasSubstr("copy.dcm: this slice lies where that of "),
                               HasSubstr("7_2.dcm lies; give one volume, with every slice once")));
}

TEST(Dicom, OrientationThatIsNone) {
  const Scratch scratch;
  write_slices(scratch / "series");
  set_decimals(scratch / "series/7_2.dcm", kOrientation, "1\\0\\0\\0.2\\1\\0");
  EXPECT_THAT(dicom_error_of(scratch / "series"),
              HasSubstr("7_2.dcm: this slice has an ImageOrientationPatient that is not two"));
}

TEST(Dicom, SlicesThatDiffer) {
  const Scratch scratch;
  write_slices(scratch / "series");
  set_decimals(scratch / "series/7_2.dcm", kSpacing, "0.7\\0.8");
  EXPECT_THAT(
      dicom_error_of(scratch / "series"),
      HasSubstr("7_2.dcm: this slice differs in size, spacing or orientation from the first"));
}

TEST(Dicom, TiltedGantryIsSheared) {
  const Scratch scratch;
  Geometry geometry = series_geometry(false);
  geometry.direction[5] = 0.05;  // slices step sideways
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  EXPECT_THAT(dicom_error_of(scratch / "series"), HasSubstr("sheared"));
}

TEST(Dicom, GreyLevelsNeedAChoice) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  auto pixels = random_pixels(geometry, 1);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::int16_t>(i % 900);
  write_series(scratch / "series", geometry, pixels, "7");
  EXPECT_THAT(dicom_error_of(scratch / "series"), HasSubstr("values from 0 to 899"));
  const Segmentation read = read_segmentation(scratch / "series", {.threshold = 450});
  for (std::size_t i = 0; i < pixels.size(); ++i) ASSERT_EQ(read.voxels[i], pixels[i] >= 450) << i;
}

}  // namespace
}  // namespace vasamesh

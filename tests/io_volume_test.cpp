/// \file
/// Volumes in: every format and pixel type, byte order, rescaling, orientation, selection. The
/// files come from ITK's writer or are made by hand.

#include <gtest/gtest.h>
#include <itkImageFileReader.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <random>
#include <sstream>

#include "io/volume_reader.h"
#include "support/itk_volumes.h"
#include "support/scratch.h"
#include "support/volume_files.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

/// Rotated about two axes; column `mirrored` is turned round.
std::array<double, 9> oblique(bool mirrored) {
  const double a = 0.3, b = -0.7;
  const double sign = mirrored ? -1 : 1;
  return {std::cos(a),
          -std::sin(a) * std::cos(b),
          sign * std::sin(a) * std::sin(b),
          std::sin(a),
          std::cos(a) * std::cos(b),
          sign * -std::cos(a) * std::sin(b),
          0,
          std::sin(b),
          sign * std::cos(b)};
}

/// More pixels than one chunk of the reader, in awkward numbers.
Geometry large_geometry() {
  return {{61, 53, 47}, {0.51, 0.52, 0.8}, {-12.5, 7.25, 101}, oblique(false)};
}

std::vector<std::uint8_t> random_mask(std::int64_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(count));
  for (auto& voxel : mask) voxel = random() % 5 == 0;
  return mask;
}

std::int64_t count_of(const Geometry& geometry) {
  return geometry.size[0] * geometry.size[1] * geometry.size[2];
}

void expect_near(const Geometry& got, const Geometry& wanted) {
  EXPECT_EQ(got.size, wanted.size);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(got.spacing[i], wanted.spacing[i], 1e-6);
    EXPECT_NEAR(got.origin[i], wanted.origin[i], 1e-4);
  }
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(got.direction[i], wanted.direction[i], 1e-6) << i;
}

template <class T>
class PixelTypes : public ::testing::Test {};
using AllPixelTypes =
    ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t,
                     std::uint32_t, long, unsigned long, float, double>;
TYPED_TEST_SUITE(PixelTypes, AllPixelTypes);

TYPED_TEST(PixelTypes, ReadInEveryFormat) {
  const Scratch scratch;
  const Geometry geometry = large_geometry();
  const auto mask = random_mask(count_of(geometry), 7);
  const auto object = static_cast<TypeParam>(std::numeric_limits<TypeParam>::max() / 2);
  std::vector<TypeParam> pixels(mask.size());
  std::transform(mask.begin(), mask.end(), pixels.begin(),
                 [=](std::uint8_t voxel) { return voxel ? object : TypeParam{0}; });
  for (const char* name : {"a.nii", "a.nii.gz", "a.mha", "a.mhd", "a.nrrd", "a.seg.nrrd"}) {
    for (const bool compress : {false, true}) {
      SCOPED_TRACE(std::string(name) + (compress ? " compressed" : ""));
      write_itk(scratch / name, geometry, pixels, compress);
      const Segmentation read = read_segmentation(scratch / name);
      EXPECT_EQ(read.voxels, mask);
      expect_near(read.geometry, geometry);
    }
  }
}

TEST(Geometries, MirroredAndFlippedAxesAreKept) {
  const Scratch scratch;
  const std::array<double, 9> directions[] = {oblique(true),
                                              {-1, 0, 0, 0, -1, 0, 0, 0, 1},
                                              {0, 0, 1, 1, 0, 0, 0, 1, 0},
                                              {1, 0, 0, 0, 1, 0, 0, 0, -1}};
  for (const auto& direction : directions) {
    const Geometry geometry{{5, 7, 3}, {0.5, 0.25, 2}, {3, -4, 5}, direction};
    const auto mask = random_mask(count_of(geometry), 3);
    for (const char* name : {"a.nii.gz", "a.mha", "a.nrrd"}) {
      SCOPED_TRACE(name);
      write_itk(scratch / name, geometry, mask, true);
      const Segmentation read = read_segmentation(scratch / name);
      EXPECT_EQ(read.voxels, mask);
      expect_near(read.geometry, geometry);
    }
  }
}

TEST(Geometries, WhatIsWrittenIsWhatItkReads) {
  const Scratch scratch;
  for (const bool mirrored : {false, true}) {
    Segmentation segmentation{large_geometry(), {}};
    segmentation.geometry.direction = oblique(mirrored);
    segmentation.voxels = random_mask(count_of(segmentation.geometry), 11);
    for (const char* name : {"b.nii", "b.nii.gz", "b.mha", "b.nrrd"}) {
      SCOPED_TRACE(name);
      write_segmentation(scratch / name, segmentation);
      using Image = itk::Image<std::uint8_t, 3>;
      auto reader = itk::ImageFileReader<Image>::New();
      reader->SetImageIO(test_image_io(name));
      reader->SetFileName(scratch / name);
      reader->Update();
      const Image& image = *reader->GetOutput();
      EXPECT_TRUE(std::equal(segmentation.voxels.begin(), segmentation.voxels.end(),
                             image.GetBufferPointer()));
      Geometry read;
      for (int a = 0; a < 3; ++a) {
        read.size[a] = static_cast<std::int64_t>(image.GetLargestPossibleRegion().GetSize()[a]);
        read.spacing[a] = image.GetSpacing()[a];
        read.origin[a] = image.GetOrigin()[a];
        for (int b = 0; b < 3; ++b) read.direction[3 * a + b] = image.GetDirection()[a][b];
      }
      expect_near(read, segmentation.geometry);
      const Segmentation again = read_segmentation(scratch / name);
      EXPECT_EQ(again.voxels, segmentation.voxels);
      expect_near(again.geometry, segmentation.geometry);
    }
  }
}

// What ITK 5.2 itself makes of a header: sform and qform in all their combinations.
TEST(Nifti, PlacedAsItkPlacesIt) {
  const Scratch scratch;
  for (const int qform_code : {0, 1, 2, 3, 4}) {
    for (const int sform_code : {0, 1, 2, 3, 4}) {
      SCOPED_TRACE(std::to_string(qform_code) + " " + std::to_string(sform_code));
      nifti_1_header header = nifti_header(3, 4, 5);
      header.qform_code = static_cast<short>(qform_code);
      header.sform_code = static_cast<short>(sform_code);
      header.quatern_c = 0.6f;
      header.quatern_d = -0.2f;
      header.pixdim[0] = -1;
      header.qoffset_y = 17;
      header.srow_x[0] = 0;
      header.srow_y[0] = 0.5f;
      header.srow_y[1] = 0;
      header.srow_x[1] = 0.5f;
      header.srow_z[3] = 4;
      write_text(scratch / "a.nii", nifti_file(header, std::string(60, '\1')));
      auto io = itk::NiftiImageIO::New();
      io->SetFileName(scratch / "a.nii");
      io->ReadImageInformation();
      const Geometry geometry = read_segmentation(scratch / "a.nii").geometry;
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(geometry.spacing[a], io->GetSpacing(a), 1e-6);
        EXPECT_NEAR(geometry.origin[a], io->GetOrigin(a), 1e-6);
        for (int b = 0; b < 3; ++b) {
          EXPECT_NEAR(geometry.direction[3 * b + a], io->GetDirection(a)[b], 1e-6);
        }
      }
    }
  }
}

// ITK 5.2 refuses this one: an offset of some hundred millimetres and no qform.
TEST(Nifti, SformWithFarOffset) {
  const Scratch scratch;
  nifti_1_header header = nifti_header(3, 4, 5);
  header.sform_code = 2;
  header.srow_x[3] = -119.46f;
  header.srow_y[3] = -226.52f;
  header.srow_z[3] = -350.66f;
  write_text(scratch / "a.nii", nifti_file(header, std::string(60, '\1')));
  const Geometry geometry = read_segmentation(scratch / "a.nii").geometry;
  expect_near(
      geometry,
      {{3, 4, 5}, {0.5, 0.5, 0.75}, {119.46, 226.52, -350.66}, {-1, 0, 0, 0, -1, 0, 0, 0, 1}});
}

TEST(Nifti, UnitsBecomeMillimetres) {
  const Scratch scratch;
  nifti_1_header header = nifti_header(3, 4, 5);
  header.srow_z[3] = 2;
  header.xyzt_units = 3;  // micrometres
  for (int i = 1; i < 4; ++i) header.pixdim[i] = 500;
  header.srow_x[0] = header.srow_y[1] = header.srow_z[2] = 500;
  write_text(scratch / "a.nii", nifti_file(header, std::string(60, '\1')));
  const Geometry geometry = read_segmentation(scratch / "a.nii").geometry;
  EXPECT_NEAR(geometry.spacing[2], 0.5, 1e-9);
  EXPECT_NEAR(geometry.origin[2], 0.002, 1e-9);
}

TEST(Nifti, BigEndianAndRescaled) {
  const Scratch scratch;
  nifti_1_header header = nifti_header(5, 3, 2);
  header.datatype = 4;
  header.bitpix = 16;
  header.scl_slope = 0.5f;
  header.scl_inter = -10;
  std::vector<std::int16_t> pixels(30, 20);
  pixels[4] = pixels[11] = 26;  // 0.5 * 26 - 10 = 3
  std::string file = nifti_file(header, bytes_of(pixels));
  write_text(scratch / "a.nii", file);
  const ReadOptions label{.label = 3};
  const auto little = read_segmentation(scratch / "a.nii", label);
  EXPECT_EQ(std::accumulate(little.voxels.begin(), little.voxels.end(), 0), 2);
  EXPECT_EQ(little.voxels[4] + little.voxels[11], 2);
  EXPECT_EQ(read_segmentation(scratch / "a.nii").voxels, little.voxels);

  const auto swap = [&](std::size_t at, std::size_t width, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i, at += width) {
      std::reverse(file.begin() + static_cast<long>(at),
                   file.begin() + static_cast<long>(at + width));
    }
  };
  swap(0, 4, 1);     // sizeof_hdr
  swap(40, 2, 8);    // dim
  swap(70, 2, 2);    // datatype, bitpix
  swap(76, 4, 8);    // pixdim
  swap(108, 4, 3);   // vox_offset, scl_slope, scl_inter
  swap(252, 2, 2);   // qform_code, sform_code
  swap(280, 4, 12);  // srow
  swap(352, 2, 30);
  write_text(scratch / "b.nii", file);
  const auto big = read_segmentation(scratch / "b.nii", label);
  EXPECT_EQ(big.voxels, little.voxels);
  expect_near(big.geometry, little.geometry);
}

TEST(MetaAndNrrd, BigEndian) {
  const Scratch scratch;
  const std::string pixels("\0\1\0\0\0\1\0\0\0\0\0\0", 12);  // 1 0 1 0 0 0
  std::string meta = meta_file(3, 2, 1, "", pixels);
  meta.replace(meta.find("MSB = False"), 11, "MSB = True");
  meta.replace(meta.find("MET_UCHAR"), 9, "MET_USHORT");
  write_text(scratch / "a.mha", meta);
  std::string nrrd = nrrd_file(3, 2, 1, "encoding: raw\nendian: big\n", pixels);
  nrrd.replace(nrrd.find("uint8"), 5, "uint16");
  write_text(scratch / "a.nrrd", nrrd);
  write_text(scratch / "b.nrrd", nrrd.replace(nrrd.find("endian"), 6, "Endian"));
  const std::vector<std::uint8_t> wanted{1, 0, 1, 0, 0, 0};
  for (const char* name : {"a.mha", "a.nrrd", "b.nrrd"}) {
    EXPECT_EQ(read_segmentation(scratch / name, {.label = 1}).voxels, wanted) << name;
  }
}

TEST(MetaAndNrrd, VoxelsInAFileOfTheirOwn) {
  const Scratch scratch;
  write_text(scratch / "voxels.raw", std::string("junk\0\1\1\0\0\1", 10));
  std::string meta = meta_file(3, 2, 1, "HeaderSize = 4\n", "");
  meta.replace(meta.find("LOCAL"), 5, "voxels.raw");
  write_text(scratch / "a.mhd", meta);
  meta.replace(meta.find("HeaderSize = 4"), 14, "HeaderSize = -1");
  write_text(scratch / "b.mhd", meta);
  const std::string detached = "encoding: raw\nbyte skip: 4\ndata file: voxels.raw\n";
  write_text(scratch / "a.nrrd", nrrd_file(3, 2, 1, detached, ""));
  const std::vector<std::uint8_t> wanted{0, 1, 1, 0, 0, 1};
  for (const char* name : {"a.mhd", "b.mhd", "a.nrrd"}) {
    EXPECT_EQ(read_segmentation(scratch / name).voxels, wanted) << name;
  }
}

TEST(MetaAndNrrd, MetadataOfNrrdAreNoFields) {
  const Scratch scratch;
  const std::string pixels("\0\1\1\0\0\1", 6);
  const std::string fields = "encoding: raw\nspacings: 2 3 4\n";
  for (const char* line :
       {"units:=\"um\" \"um\" \"um\"", "encoding:=foo", "data file:=x.raw", "byte skip:=5",
        "sizes:=1 2 3", "spacings:=0 0 0", "space:=LAS", "note:=key: value"}) {
    SCOPED_TRACE(line);
    write_text(scratch / "a.nrrd", nrrd_file(3, 2, 1, fields + line + "\n", pixels));
    const Segmentation read = read_segmentation(scratch / "a.nrrd");
    EXPECT_EQ(read.voxels, std::vector<std::uint8_t>(pixels.begin(), pixels.end()));
    expect_near(read.geometry, {{3, 2, 1}, {2, 3, 4}, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}});
  }
}

TEST(MetaAndNrrd, TheLastBytesOfCompressedNrrd) {
  const Scratch scratch;
  const std::string pixels("\0\1\1\0\0\1", 6);
  for (const char* junk : {"", "junk of some length"}) {
    write_text(scratch / "a.nrrd",
               nrrd_file(3, 2, 1, "encoding: gzip\nbyte skip: -1\n", gzip(junk + pixels)));
    EXPECT_EQ(read_segmentation(scratch / "a.nrrd").voxels,
              std::vector<std::uint8_t>(pixels.begin(), pixels.end()));
  }
}

TEST(MetaAndNrrd, ColonsInMetaImage) {
  const Scratch scratch;
  std::string meta = meta_file(3, 2, 1, "ElementSpacing = 2 3 4\nComment = a: b\n",
                               std::string("\0\1\1\0\0\1", 6));
  for (std::size_t at; (at = meta.find(" = ")) != std::string::npos;) meta.replace(at, 3, " : ");
  write_text(scratch / "a.mha", meta);
  const Segmentation read = read_segmentation(scratch / "a.mha");
  EXPECT_EQ(read.voxels, (std::vector<std::uint8_t>{0, 1, 1, 0, 0, 1}));
  EXPECT_NEAR(read.geometry.spacing[2], 4, 1e-9);
}

/// "(1,2,3)" of a vector of LPS in a space whose x and y have these signs.
std::string vector_text(const std::array<double, 3>& lps, const std::array<double, 2>& signs) {
  std::ostringstream text;
  text << std::setprecision(17) << "(" << signs[0] * lps[0] << "," << signs[1] * lps[1] << ","
       << lps[2] << ")";
  return text.str();
}

// ITK 5.2 turns the wrong axis of LAS round.
TEST(MetaAndNrrd, ThePlaceInEverySpaceOfNrrd) {
  const Scratch scratch;
  const Geometry wanted{{3, 4, 5}, {0.5, 0.75, 1.25}, {-12.5, 7.25, 101}, oblique(true)};
  const std::pair<const char*, std::array<double, 2>> spaces[] = {
      {"left-posterior-superior", {1, 1}},
      {"right-anterior-superior", {-1, -1}},
      {"left-anterior-superior", {1, -1}},
      {"LPS", {1, 1}},
      {"RAS", {-1, -1}},
      {"LAS", {1, -1}}};
  for (const auto& [space, signs] : spaces) {
    SCOPED_TRACE(space);
    std::string lines = "encoding: raw\nspace: " + std::string(space) + "\nspace directions:";
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<double, 3> step;
      for (std::size_t row = 0; row < 3; ++row)
        step[row] = wanted.spacing[axis] * wanted.direction[3 * row + axis];
      lines.append(" ").append(vector_text(step, signs));
    }
    lines += "\nspace origin: " + vector_text(wanted.origin, signs) + "\n";
    write_text(scratch / "a.nrrd", nrrd_file(3, 4, 5, lines, std::string(60, '\1')));
    expect_near(read_segmentation(scratch / "a.nrrd").geometry, wanted);
  }
}

// ITK 5.2 takes every length for mm.
TEST(MetaAndNrrd, UnitsOfNrrdBecomeMillimetres) {
  const Scratch scratch;
  const std::pair<const char*, double> units[] = {
      {"um", 1e-3},      {"\xc2\xb5m", 1e-3}, {"\xce\xbcm", 1e-3}, {"\xb5m", 1e-3},
      {"microns", 1e-3}, {"MM", 1},           {"millimetres", 1},  {"", 1},
      {"cm", 10},        {"m", 1e3}};
  for (const auto& [unit, in_mm] : units) {
    SCOPED_TRACE(unit);
    std::ostringstream three;
    for (int axis = 0; axis < 3; ++axis) three << std::quoted(unit) << " ";
    const Geometry wanted{{3, 4, 5},
                          {2 * in_mm, 3 * in_mm, 4 * in_mm},
                          {10 * in_mm, 20 * in_mm, 30 * in_mm},
                          {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const std::string of_space =
        "encoding: raw\nspace: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) "
        "(0,0,4)\nspace origin: (10,20,30)\nspace units: " +
        three.str() + "\n";
    write_text(scratch / "a.nrrd", nrrd_file(3, 4, 5, of_space, std::string(60, '\1')));
    expect_near(read_segmentation(scratch / "a.nrrd").geometry, wanted);
    const std::string of_axes = "encoding: raw\nspacings: 2 3 4\nunits: " + three.str() + "\n";
    write_text(scratch / "b.nrrd", nrrd_file(3, 4, 5, of_axes, std::string(60, '\1')));
    EXPECT_NEAR(read_segmentation(scratch / "b.nrrd").geometry.spacing[2], 4 * in_mm, 1e-9);
  }
}

TEST(MetaAndNrrd, UnitsOfMetaImageBecomeMillimetres) {
  const Scratch scratch;
  const std::pair<const char*, double> units[] = {
      {"um", 1e-3}, {"mm", 1}, {"cm", 10}, {"?", 1}, {"", 1}};
  for (const auto& [unit, in_mm] : units) {
    SCOPED_TRACE(unit);
    const std::string lines =
        "ElementSpacing = 2 3 4\nOffset = 10 20 30\nDistanceUnits = " + std::string(unit) + "\n";
    write_text(scratch / "a.mha", meta_file(3, 4, 5, lines, std::string(60, '\1')));
    expect_near(read_segmentation(scratch / "a.mha").geometry,
                {{3, 4, 5},
                 {2 * in_mm, 3 * in_mm, 4 * in_mm},
                 {10 * in_mm, 20 * in_mm, 30 * in_mm},
                 {1, 0, 0, 0, 1, 0, 0, 0, 1}});
  }
}

TEST(Shapes, OneSliceTwoAxesAndTrailingAxes) {
  const Scratch scratch;
  nifti_1_header header = nifti_header(3, 2, 1);
  const std::string pixels("\0\1\1\0\0\1", 6);
  write_text(scratch / "slice.nii", nifti_file(header, pixels));
  EXPECT_EQ(read_segmentation(scratch / "slice.nii").geometry.spacing[2], 0.75);
  header.dim[0] = 4;
  write_text(scratch / "four.nii", nifti_file(header, pixels));
  EXPECT_EQ(read_segmentation(scratch / "four.nii").voxels.size(), 6u);
  header.dim[0] = 2;
  header.pixdim[2] = header.srow_y[1] = 2;
  write_text(scratch / "flat.nii", nifti_file(header, pixels));
  std::string meta = meta_file(3, 2, 1, "ElementSpacing = 0.5 2\n", pixels);
  meta.replace(meta.find("NDims = 3"), 9, "NDims = 2");
  meta.replace(meta.find("3 2 1"), 5, "3 2");
  write_text(scratch / "flat.mha", meta);
  for (const char* name : {"flat.nii", "flat.mha"}) {
    const Segmentation flat = read_segmentation(scratch / name);
    EXPECT_EQ(flat.geometry.size, (std::array<std::int64_t, 3>{3, 2, 1})) << name;
    EXPECT_NEAR(flat.geometry.spacing[2], 1, 1e-7) << name;
    EXPECT_EQ(flat.voxels, (std::vector<std::uint8_t>{0, 1, 1, 0, 0, 1})) << name;
  }
}

// Rows of 61 voxels, in several chunks of the file: their ends share bytes.
TEST(Packed, ABitAVoxelInRowsOfWholeBytes) {
  const Scratch scratch;
  const Geometry geometry = large_geometry();
  const auto mask = random_mask(count_of(geometry), 5);
  write_itk(scratch / "a.nii.gz", geometry, mask, true);
  const PackedSegmentation packed = read_packed(scratch / "a.nii.gz");
  expect_near(packed.geometry, geometry);
  const std::size_t length = 61, row_bytes = 8;
  ASSERT_EQ(packed.bits.size(), row_bytes * 53 * 47);
  for (std::size_t row = 0; row < 53 * 47; ++row)
    for (std::size_t x = 0; x < 8 * row_bytes; ++x)
      ASSERT_EQ(packed.bits[row * row_bytes + x / 8] >> (x % 8) & 1,
                x < length ? mask[row * length + x] : 0)
          << row << " " << x;
  const VolumeView view = packed.view();
  EXPECT_EQ(view.format, VoxelFormat::bits);
  EXPECT_EQ(view.data, packed.bits.data());
}

/// Writes int16 values into a volume of one row and reads it.
std::vector<std::uint8_t> select(const std::vector<std::int16_t>& values,
                                 const ReadOptions& options = {}) {
  const Scratch scratch;
  nifti_1_header header = nifti_header(static_cast<int>(values.size()), 1, 1);
  header.datatype = 4;
  write_text(scratch / "a.nii", nifti_file(header, bytes_of(values)));
  return read_segmentation(scratch / "a.nii", options).voxels;
}

using Mask = std::vector<std::uint8_t>;

TEST(Selection, TheOnlyOtherValueIsTheObject) {
  EXPECT_EQ(select({0, 255, 0, 255}), (Mask{0, 1, 0, 1}));
  EXPECT_EQ(select({0, -7, 0}), (Mask{0, 1, 0}));
  EXPECT_EQ(select({9, 9, 9}), (Mask{1, 1, 1}));
}

TEST(Selection, ByLabelAnyLabelAndThreshold) {
  const std::vector<std::int16_t> values{0, 1, 2, -3, 2, 400};
  EXPECT_EQ(select(values, {.label = 2}), (Mask{0, 0, 1, 0, 1, 0}));
  EXPECT_EQ(select(values, {.label = -3}), (Mask{0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(select(values, {.any_label = true}), (Mask{0, 1, 1, 1, 1, 1}));
  EXPECT_EQ(select(values, {.threshold = 2}), (Mask{0, 0, 1, 0, 1, 1}));
  EXPECT_EQ(select(values, {.threshold = 1.5}), (Mask{0, 0, 1, 0, 1, 1}));
  EXPECT_EQ(select(values, {.threshold = -2.5}), (Mask{1, 1, 1, 0, 1, 1}));
  EXPECT_EQ(select(values, {.threshold = -1e9}), (Mask{1, 1, 1, 1, 1, 1}));
}

TEST(Selection, LabelsBeyondDoublePrecision) {
  const Scratch scratch;
  const std::int64_t big = (std::int64_t{1} << 60) + 1;
  nifti_1_header header = nifti_header(3, 1, 1);
  header.datatype = 1024;
  write_text(scratch / "a.nii",
             nifti_file(header, bytes_of(std::vector<std::int64_t>{big, big - 1, 0})));
  EXPECT_EQ(read_segmentation(scratch / "a.nii", {.label = big}).voxels, (Mask{1, 0, 0}));
  EXPECT_THROW(read_segmentation(scratch / "a.nii"), Error);
}

TEST(Selection, InfinityIsAboveAThreshold) {
  const Scratch scratch;
  nifti_1_header header = nifti_header(3, 1, 1);
  header.datatype = 16;
  write_text(scratch / "a.nii",
             nifti_file(header, bytes_of(std::vector<float>{INFINITY, 0.5f, -INFINITY})));
  EXPECT_EQ(read_segmentation(scratch / "a.nii", {.threshold = 0.75}).voxels, (Mask{1, 0, 0}));
}

TEST(Compressed, SeveralGzipMembersAndPadding) {
  const Scratch scratch;
  const std::string file = nifti_file(nifti_header(3, 2, 1), std::string("\0\1\1\0\0\1", 6));
  const std::string split = gzip(file.substr(0, 353)) + gzip(file.substr(353));
  write_text(scratch / "a.nii.gz", split + std::string(512, '\0'));
  EXPECT_EQ(read_segmentation(scratch / "a.nii.gz").voxels, (Mask{0, 1, 1, 0, 0, 1}));
}

TEST(Reading, StopsWhenItIsToldTo) {
  const Scratch folder;
  Segmentation segmentation;
  segmentation.geometry.size = {64, 64, 64};
  segmentation.voxels.assign(64 * 64 * 64, 1);
  const std::atomic<bool> cancel{true};
  ReadOptions options;
  options.cancel = &cancel;
  for (const char* name : {"full.nii.gz", "full.mha", "full.nrrd"}) {
    write_segmentation(folder / name, segmentation);
    try {
      read_segmentation(folder / name, options);
      ADD_FAILURE() << name << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled) << error.what();
    }
  }
}

}  // namespace
}  // namespace vasamesh

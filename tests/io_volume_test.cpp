/// \file
/// Volumes in: every format and pixel type, orientation, selection. The files come from ITK's
/// writer or are made by hand. What is of one format alone: io_nifti_test.cpp and
/// io_meta_nrrd_test.cpp.

#include <gtest/gtest.h>
#include <itkImageFileReader.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "io/volume_reader.h"
#include "support/geometries.h"
#include "support/itk_volumes.h"
#include "support/scratch.h"
#include "support/volume_files.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

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

/// \file
/// Volumes that must be refused: each with its code, its file, its reason and its remedy in one
/// line, and nothing printed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <random>

#include "io/volume_formats.h"
#include "io/volume_reader.h"
#include "support/full_disk.h"
#include "support/itk_volumes.h"
#include "support/leaks.h"
#include "support/scratch.h"
#include "support/volume_files.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using ::testing::HasSubstr;

constexpr int kSide = 4;
const std::string kPixels = std::string("\1\0\0\1", 4) + std::string(60, '\0');

class BadVolume : public ::testing::Test {
 protected:
  /// Expects an error of one line that names the file and holds `reason` and `remedy`.
  void expect_error(const std::string& path, ErrorCode code, const std::string& reason,
                    const std::string& remedy, const ReadOptions& options = {}) {
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    try {
      read_segmentation(path, options);
      ADD_FAILURE() << path << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(reason));
      EXPECT_THAT(error.what(), HasSubstr(remedy));
      EXPECT_THAT(error.what(), HasSubstr(std::filesystem::path(path).stem().stem().string()));
      EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("\n")));
    }
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }

  void expect_bad(const std::string& path, const std::string& reason, const std::string& remedy,
                  const ReadOptions& options = {}) {
    expect_error(path, ErrorCode::bad_input, reason, remedy, options);
  }

  std::string write(const std::string& name, const std::string& bytes) {
    write_text(scratch_ / name, bytes);
    return scratch_ / name;
  }

  std::string write_nifti(const nifti_1_header& header, const std::string& pixels = kPixels) {
    return write("bad.nii", nifti_file(header, pixels));
  }

  template <class T>
  std::string write_values(short datatype, const std::vector<T>& values) {
    nifti_1_header header = nifti_header(static_cast<int>(values.size()), 1, 1);
    header.datatype = datatype;
    return write_nifti(header, bytes_of(values));
  }

  Scratch scratch_;
  nifti_1_header header_ = nifti_header(kSide, kSide, kSide);
};

TEST_F(BadVolume, GoodOnesAreRead) {
  EXPECT_NO_THROW(read_segmentation(write_nifti(header_)));
  EXPECT_NO_THROW(read_segmentation(write("a.mha", meta_file(kSide, kSide, kSide, "", kPixels))));
  EXPECT_NO_THROW(read_segmentation(
      write("a.nrrd", nrrd_file(kSide, kSide, kSide, "encoding: raw\n", kPixels))));
}

TEST_F(BadVolume, NoSuchFileUnknownFormatEmptyOrGarbage) {
  expect_bad(scratch_ / "absent.nii.gz", "no such file", "check the name");
  expect_bad(write("bad.txt", "hello"), "unknown format", ".nii.gz");
  for (const char* name : {"bad.nii", "bad.nii.gz", "bad.mha", "bad.nrrd"}) {
    expect_bad(write(name, ""), "empty file", "whole copy");
  }
  expect_bad(write("bad.nii", "short"), "no NIfTI file", "check its format");
  expect_bad(write("bad.nii", std::string(500, 'x')), "no NIfTI file", "check its format");
  expect_bad(write("bad.nii.gz", std::string(500, 'x')), "not gzip-compressed", "whole copy");
  expect_bad(write("bad.nii.gz", nifti_file(header_, kPixels)), "not gzip-compressed", "rename it");
  expect_bad(write("bad.nii.gz", "\x1f\x8b" + std::string(500, 'x')), "corrupt", "whole copy");
  expect_bad(write("bad.mha", std::string(500, 'x')), "header does not end", "whole copy");
  expect_bad(write("bad.mha", "NDims = 3\nElementDataFile = LOCAL\n"), "not a 3D volume", "3D");
  expect_bad(write("bad.nrrd", std::string(500, 'x')), "no NRRD file", "check its format");
}

TEST_F(BadVolume, FilesThatAreThereAndCannotBeReached) {
  std::filesystem::create_symlink("bad.nrrd", scratch_ / "bad.nrrd");
  expect_bad(scratch_ / "bad.nrrd", "Too many levels of symbolic links", "check its name");
  expect_bad(scratch_ / "bad" + std::string(300, 'd'), "File name too long", "check its name");
}

TEST_F(BadVolume, FolderWithoutASeries) {
  std::filesystem::create_directory(scratch_ / "folder");
  expect_bad(scratch_ / "folder", "without a DICOM series", "give a file");
  write_text(scratch_ / "folder/note.txt", "hello");
  expect_bad(scratch_ / "folder", "without a DICOM series", "give a file");
}

TEST_F(BadVolume, TruncatedOrCorruptGzip) {
  const std::string whole = gzip(nifti_file(header_, kPixels));
  for (const std::size_t cut : {std::size_t{1}, std::size_t{5}, std::size_t{8}, whole.size() / 2}) {
    expect_bad(write("bad.nii.gz", whole.substr(0, whole.size() - cut)), "truncated", "whole copy");
  }
  std::string checksum = whole;
  checksum[whole.size() - 6] ^= 1;
  expect_bad(write("bad.nii.gz", checksum), "corrupt", "whole copy");
  std::string length = whole;
  length[whole.size() - 2] ^= 1;
  expect_bad(write("bad.nii.gz", length), "corrupt", "whole copy");
}

/// A compressed volume of 52 chunks of the reader, more than it has in hand at once.
std::string long_stream() {
  std::mt19937 random(6);
  std::string pixels(190 * 190 * 190, '\0');
  for (char& pixel : pixels) pixel = random() % 3 == 0;
  return gzip(nifti_file(nifti_header(190, 190, 190), pixels), 1);
}

TEST_F(BadVolume, DamageInTheMiddleOfALongStream) {
  const std::string whole = long_stream();
  EXPECT_NO_THROW(read_packed(write("good.nii.gz", whole)));
  expect_bad(write("bad.nii.gz", whole.substr(0, whole.size() / 2)), "truncated", "whole copy");
  std::string altered = whole;
  altered[whole.size() / 2] ^= 0x55;
  expect_bad(write("bad.nii.gz", altered), "corrupt", "whole copy");
}

TEST_F(BadVolume, WhatAVisitorThrowsEndsTheReading) {
  const Volume volume = open_nifti(write("good.nii.gz", long_stream()));
  std::atomic<int> chunks{0};
  const auto visit = [&] {
    volume.pixels->visit([&](const PixelChunk&) {
      if (++chunks >= 3) throw Error(ErrorCode::cancelled, "enough");
    });
  };
  try {
    visit();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
  EXPECT_LT(chunks, 30);
}

TEST_F(BadVolume, TruncatedCompressedMetaAndNrrd) {
  const Geometry geometry{{kSide, kSide, kSide}, {1, 1, 1}, {0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const std::vector<std::uint8_t> pixels(kPixels.begin(), kPixels.end());
  for (const char* name : {"bad.mha", "bad.nrrd"}) {
    write_itk(scratch_ / name, geometry, pixels, true);
    const std::string whole = read_text(scratch_ / name);
    expect_bad(write(name, whole.substr(0, whole.size() - 2)), "truncated", "whole copy");
    std::string checksum = whole;
    checksum[whole.size() - 6] ^= 1;
    EXPECT_THROW(read_segmentation(write(name, checksum)), Error);
  }
}

TEST_F(BadVolume, FewerOrMoreVoxelsThanTheHeaderSays) {
  const std::string few = kPixels.substr(0, 50);
  const std::string many = kPixels + std::string(100'000, '\0');
  for (const bool compressed : {false, true}) {
    const auto pack = [&](const std::string& bytes) { return compressed ? gzip(bytes) : bytes; };
    const std::string name = compressed ? "bad.nii.gz" : "bad.nii";
    expect_bad(write(name, pack(nifti_file(header_, few))),
               compressed ? "fewer voxels" : "more than", "whole copy");
    expect_bad(write(name, pack(nifti_file(header_, many))), "more voxels", "write the volume");
  }
  expect_bad(write("bad.mha", meta_file(kSide, kSide, kSide, "", few)), "more than a file",
             "whole copy");
  expect_bad(write("bad.nrrd", nrrd_file(kSide, kSide, kSide, "encoding: raw\n", few)),
             "more than a file", "whole copy");
}

TEST_F(BadVolume, TerabytesAreRefusedBeforeTheyAreAllocated) {
  for (int i = 1; i <= 3; ++i) header_.dim[i] = 30'000;
  expect_bad(write_nifti(header_), "27000000000000 voxels, more than a file", "whole copy");
  expect_bad(write("bad.nii.gz", gzip(nifti_file(header_, kPixels))), "more than a file",
             "whole copy");
  expect_bad(write("bad.mha", meta_file(900'000, 900'000, 900'000, "", kPixels)),
             "more than a file", "whole copy");
  expect_bad(write("bad.nrrd", nrrd_file(900'000, 900'000, 900'000, "encoding: raw\n", kPixels)),
             "more than a file", "whole copy");
  expect_bad(write("bad.mha", meta_file(900'000'000, 900'000'000, 900'000'000, "", kPixels)),
             "impossible", "write the volume");
}

/// ITK takes 2^32 + 4 for 4.
TEST_F(BadVolume, SizesThatAreNone) {
  for (const char* size : {"4294967300", "99999999999999", "0", "-3", "4.5"}) {
    std::string nrrd = nrrd_file(kSide, kSide, kSide, "encoding: raw\n", kPixels);
    nrrd.replace(nrrd.find("sizes: 4"), 8, "sizes: " + std::string(size));
    expect_bad(write("bad.nrrd", nrrd), "its size of " + std::string(size) + " voxels along",
               "write the volume again");
    std::string meta = meta_file(kSide, kSide, kSide, "", kPixels);
    meta.replace(meta.find("DimSize = 4"), 11, "DimSize = " + std::string(size));
    expect_bad(write("bad.mha", meta), "its size of " + std::string(size) + " voxels along",
               "write the volume again");
  }
}

TEST_F(BadVolume, MoreMemoryThanAllowed) {
  expect_error(write_nifti(header_), ErrorCode::refused, "64 bytes of memory, 63 are allowed",
               "--max-memory", {.max_memory = 63});
  EXPECT_NO_THROW(read_segmentation(write_nifti(header_), {.max_memory = 64}));
  // 4 x 4 rows of 4 voxels, a byte each.
  EXPECT_NO_THROW(read_packed(write_nifti(header_), {.max_memory = 16}));
  EXPECT_THROW(read_packed(write_nifti(header_), {.max_memory = 15}), Error);
}

TEST_F(BadVolume, NotThreeDimensional) {
  nifti_1_header series = header_;
  series.dim[0] = 4;
  series.dim[4] = 3;
  expect_bad(write_nifti(series, kPixels + kPixels + kPixels), "series of 3 volumes", "extract");
  series.dim[0] = 5;
  series.dim[4] = 1;
  series.dim[5] = 3;
  expect_bad(write_nifti(series, kPixels + kPixels + kPixels), "several components", "extract");
  series.dim[0] = 1;
  expect_bad(write_nifti(series), "not a 3D volume", "3D");
  series.dim[0] = 3;
  series.dim[2] = 0;
  expect_bad(write_nifti(series), "below one voxel", "write the volume");
  std::string meta = meta_file(kSide, kSide, kSide, "", kPixels);
  meta.replace(meta.find("NDims = 3"), 9, "NDims = 4");
  meta.replace(meta.find("4 4 4"), 5, "4 4 2 2");
  expect_bad(write("bad.mha", meta), "series of 2 volumes", "extract");
}

TEST_F(BadVolume, ColoursAndVectors) {
  header_.datatype = 128;
  expect_bad(write_nifti(header_, kPixels + kPixels + kPixels), "not scalar", "label map");
  expect_bad(write("bad.mha", meta_file(kSide, kSide, kSide, "ElementNumberOfChannels = 3\n",
                                        kPixels + kPixels + kPixels)),
             "3 components", "label map");
  std::string layers = nrrd_file(
      2, kSide, kSide, "kinds: list domain domain domain\nencoding: raw\n", kPixels + kPixels);
  layers.replace(layers.find("dimension: 3"), 12, "dimension: 4");
  layers.replace(layers.find("2 4 4"), 5, "2 4 4 4");
  expect_bad(write("bad.seg.nrrd", layers), "2 components", "label map");
}

TEST_F(BadVolume, UnusualEncodings) {
  expect_bad(write("bad.nrrd", nrrd_file(1, 1, 2, "encoding: ascii\n", "0 1\n")), "\"ascii\"",
             "raw or gzip");
  std::string text = meta_file(1, 1, 2, "", "0 1\n");
  text.replace(text.find("BinaryData = True"), 17, "BinaryData = False");
  expect_bad(write("bad.mha", text), "voxels are text", "binary");
  std::string list = meta_file(1, 1, 2, "", "a.raw\nb.raw\n");
  list.replace(list.find("LOCAL"), 5, "LIST");
  expect_bad(write("bad.mhd", list), "several files", "one .mha file");
  list.replace(list.find("LIST"), 4, "LIST 2");
  expect_bad(write("bad.mhd", list), "several files", "one .mha file");
  header_.sizeof_hdr = 540;
  expect_bad(write_nifti(header_), "NIfTI-2", "NIfTI-1");
}

TEST_F(BadVolume, DataFilesThatAreMissing) {
  std::string meta = meta_file(kSide, kSide, kSide, "", "");
  meta.replace(meta.find("LOCAL"), 5, "bad.raw");
  expect_bad(write("bad.mhd", meta), "bad.raw: no such file", "check the name");
  meta.replace(meta.find("bad.raw"), 7, "");
  expect_bad(write("bad.mhd", meta), "names no file", "name the file");
  const std::string lines = "encoding: raw\ndata file: bad.raw\n";
  expect_bad(write("bad.nrrd", nrrd_file(kSide, kSide, kSide, lines, "")), "bad.raw: no such file",
             "check the name");
}

TEST_F(BadVolume, NrrdWithoutItsByteOrder) {
  const auto typed = [](const std::string& type, const std::string& lines) {
    std::string file = nrrd_file(kSide, kSide, kSide, "encoding: raw\n" + lines, kPixels + kPixels);
    return file.replace(file.find("uint8"), 5, type);
  };
  expect_bad(write("bad.nrrd", typed("short", "")), "byte order", "endian: little");
  EXPECT_NO_THROW(
      read_segmentation(write("a.nrrd", typed("short", "endian: little\n")), {.any_label = true}));
  for (const char* type : {"signed char", "uchar", "uint8_t", "Int8"})
    EXPECT_NO_THROW(read_segmentation(write("a.nrrd", typed(type, ""))));
}

TEST_F(BadVolume, NrrdInUnitsThatAreUnknownOrMixed) {
  const auto file = [&](const std::string& units) {
    return write("bad.nrrd", nrrd_file(kSide, kSide, kSide, "encoding: raw\n" + units, kPixels));
  };
  const std::string space =
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace units: ";
  expect_bad(file(space + "\"inch\" \"inch\" \"inch\"\n"), "unit of length is \"inch\"",
             "space units");
  expect_bad(file(space + "\"mm\" \"mm\" \"um\"\n"), "\"mm\" and \"um\"", "in one unit");
  expect_bad(file("spacings: 1 1 1\nunits: \"um\" \"um\" \"\"\n"), "\"um\" and \"\"",
             "in one unit");
}

TEST_F(BadVolume, SpacingOfEveryBadKind) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double spacing : {0.0, -0.75, nan, infinite}) {
    nifti_1_header header = header_;
    header.pixdim[3] = static_cast<float>(spacing);
    expect_bad(write_nifti(header), "not a length above zero", "correct the spacing");
  }
  for (const char* spacing : {"0", "-1", "nan", "inf"}) {
    const std::string three = "1 1 " + std::string(spacing) + "\n";
    expect_bad(
        write("bad.mha", meta_file(kSide, kSide, kSide, "ElementSpacing = " + three, kPixels)),
        "not a length above zero", "correct the spacing");
    expect_bad(write("bad.nrrd", nrrd_file(kSide, kSide, kSide,
                                           "spacings: " + three + "encoding: raw\n", kPixels)),
               "not a length above zero", "correct the spacing");
  }
  expect_bad(
      write("bad.mha", meta_file(kSide, kSide, kSide, "ElementSpacing = 1e5 1e5 1e5\n", kPixels)),
      "absurd", "mm");
  expect_bad(write("bad.mha",
                   meta_file(kSide, kSide, kSide, "ElementSpacing = 1e-7 1e-7 1e-7\n", kPixels)),
             "absurd", "mm");
  expect_bad(
      write("bad.mha", meta_file(kSide, kSide, kSide, "ElementSpacing = 1 1 101\n", kPixels)),
      "100-fold", "mm");
}

TEST_F(BadVolume, ShearedDirection) {
  nifti_1_header header = header_;
  header.srow_x[1] = 0.01f;
  expect_bad(write_nifti(header), "sheared", "resample");
  header.qform_code = 1;  // the qform cannot be sheared, and takes over
  header.sform_code = 2;
  EXPECT_NO_THROW(read_segmentation(write_nifti(header)));
  expect_bad(write("bad.mha", meta_file(kSide, kSide, kSide,
                                        "TransformMatrix = 1 0.01 0 0 1 0 0 0 1\n", kPixels)),
             "sheared", "resample");
  expect_bad(write("bad.nrrd",
                   nrrd_file(kSide, kSide, kSide,
                             "space: left-posterior-superior\nspace directions: (1,0,0) (0.01,1,0) "
                             "(0,0,1)\nencoding: raw\n",
                             kPixels)),
             "sheared", "resample");
}

TEST_F(BadVolume, SformAgainstSpacing) {
  header_.srow_z[2] = 1.5f;
  expect_bad(write_nifti(header_), "disagree", "correct its header");
}

TEST_F(BadVolume, SformThatIsNotFinite) {
  header_.srow_y[1] = std::numeric_limits<float>::quiet_NaN();
  expect_bad(write_nifti(header_), "sform is not finite", "correct its header");
}

TEST_F(BadVolume, OriginThatIsNotFinite) {
  header_.srow_y[3] = std::numeric_limits<float>::quiet_NaN();
  expect_bad(write_nifti(header_), "origin is not finite", "correct the origin");
}

TEST_F(BadVolume, SeveralLabels) {
  expect_bad(write_values<std::int16_t>(4, {0, 3, 1, 2}), "3 labels (1, 2, 3)",
             "--label N, all with --label any");
  std::vector<std::int16_t> many(40);
  std::iota(many.begin(), many.end(), 0);
  expect_bad(write_values(4, many), "39 labels (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, ...)", "--label N");
  expect_bad(write_values<std::int16_t>(4, {5, 7, 7}), "2 labels (5, 7)", "--label N");
}

TEST_F(BadVolume, GreyLevels) {
  std::vector<std::int16_t> many(2000);
  std::iota(many.begin(), many.end(), -1000);
  expect_bad(write_values(4, many), "grey levels, values from -1000 to 999", "--threshold T");
  expect_bad(write_values<float>(16, {0, 0.25f, 0.75f}), "grey levels, values from 0 to 0.75",
             "--threshold T");
}

TEST_F(BadVolume, AbsentLabelAndEmptyForeground) {
  expect_bad(write_values<std::int16_t>(4, {0, 3, 1}),
             "label 2 is absent, it holds 2 labels (1, 3)", "choose one", {.label = 2});
  expect_bad(write_values<std::uint8_t>(2, {0, 3, 1}), "label 300 is absent", "choose one",
             {.label = 300});
  const std::vector<std::uint8_t> blank{0, 0, 0};
  expect_bad(write_values(2, blank), "nothing in the foreground", "with an object");
  expect_bad(write_values(2, blank), "nothing in the foreground", "with an object", {.label = 1});
  expect_bad(write_values(2, blank), "nothing in the foreground", "with an object",
             {.any_label = true});
  expect_bad(write_values<std::int16_t>(4, {-5, 3}),
             "no voxel reaches the threshold 3.5, it holds "
             "values from -5 to 3",
             "lower", {.threshold = 3.5});
}

TEST_F(BadVolume, NanAndInfinity) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const ReadOptions choices[] = {{}, {.label = 1}, {.any_label = true}, {.threshold = 0.5}};
  for (const ReadOptions& choice : choices) {
    expect_bad(write_values<float>(16, {0, 1, nan}), "holds NaN", "background", choice);
    if (choice.threshold) continue;
    expect_bad(write_values<float>(16, {0, 1, infinite}), "infinite", "--threshold T", choice);
    expect_bad(write_values<double>(64, {0, -infinite, 0}), "infinite", "--threshold T", choice);
  }
}

TEST_F(BadVolume, SelectionsThatExcludeEachOther) {
  ReadOptions both{.label = 1};
  both.threshold = 2;
  try {
    read_segmentation(write_nifti(header_), both);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage);
    EXPECT_THAT(error.what(), HasSubstr("--label and --threshold"));
  }
}

TEST_F(BadVolume, OutputThatCannotBe) {
  const Segmentation segmentation{{{1, 1, 1}, {1, 1, 1}, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {1}};
  const auto code = [&](const std::string& path) {
    try {
      write_segmentation(path, segmentation);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::internal;
  };
  EXPECT_EQ(code(scratch_ / "a.vtp"), ErrorCode::usage);
  EXPECT_EQ(code(scratch_ / "missing/a.nii"), ErrorCode::refused);
  std::filesystem::create_directory(scratch_ / "a.nii");
  EXPECT_EQ(code(scratch_ / "a.nii"), ErrorCode::refused);
}

TEST_F(BadVolume, AFullDiskLeavesTheOldFile) {
  Segmentation segmentation{{{64, 64, 64}, {1, 1, 1}, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {}};
  std::mt19937 random(1);
  for (int i = 0; i < 64 * 64 * 64; ++i) segmentation.voxels.push_back(random() % 2);
  for (const char* name : {"a.nii", "a.nii.gz", "a.mha", "a.nrrd"}) {
    SCOPED_TRACE(name);
    write(name, "old");
    testing::internal::CaptureStderr();
    {
      const FullDisk full(10'000);
      try {
        write_segmentation(scratch_ / name, segmentation);
        ADD_FAILURE();
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::refused) << error.what();
        EXPECT_THAT(error.what(), HasSubstr("make room"));
      }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(read_text(scratch_ / name), "old");
  }
  EXPECT_EQ(scratch_.names().size(), 4u);
}

}  // namespace
}  // namespace vasamesh

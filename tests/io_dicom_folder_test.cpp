/// \file
/// DICOM folders: which of their files are slices, and that none is lost.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "io/volume_reader.h"
#include "support/dicom_files.h"
#include "support/scratch.h"

namespace vasamesh {
namespace {

using ::testing::HasSubstr;

/// Permissions count for the life of the object, even where root runs the tests.
class AsNobody {
 public:
  AsNobody() { is_root_ = geteuid() == 0 && seteuid(65534) == 0; }
  ~AsNobody() {
    if (is_root_) {
      EXPECT_EQ(seteuid(0), 0);
    }
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  bool is_root_ = false;
};

TEST(DicomFolder, SeveralSeriesAreNamed) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "8");
  const std::string message = dicom_error_of(scratch / "series");
  EXPECT_THAT(message, HasSubstr("2 DICOM series (1.2.826.0.1.3680043.2.7"));
  EXPECT_THAT(message, HasSubstr("1.2.826.0.1.3680043.2.8"));
  EXPECT_THAT(message, HasSubstr("a folder of its own"));
}

TEST(DicomFolder, ErrorsAreOneLine) {
  const Scratch scratch;
  write_slices(scratch / "series");
  edit(scratch / "series/7_2.dcm", [](gdcm::DataSet& set) {
    set_text(set, kSeriesUid, gdcm::VR::UI, std::string("1.\n2\0003", 6));
  });
  EXPECT_THAT(dicom_error_of(scratch / "series"),
              HasSubstr("2 DICOM series (1.2.826.0.1.3680043.2.7, 1.?2)"));
}

TEST(DicomFolder, TruncatedSlice) {
  const Scratch scratch;
  const Geometry geometry = series_geometry(false);
  write_series(scratch / "series", geometry, random_pixels(geometry, 1), "7");
  const std::string bytes = read_text(scratch / "series/7_2.dcm");
  write_text(scratch / "series/7_2.dcm", bytes.substr(0, bytes.size() - 100));
  EXPECT_THAT(dicom_error_of(scratch / "series"), HasSubstr("7_2.dcm: truncated"));
}

TEST(DicomFolder, WhatIsNoSliceIsLeftAside) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  const Geometry geometry = write_slices(folder);
  write_text(folder + "/DICOMDIR", "");
  write_text(folder + "/.DS_Store", std::string(200, '\0'));
  write_text(folder + "/._7_0.dcm", std::string("\0\5\x16\7", 4));
  write_text(folder + "/README", "no ending");
  write_text(folder + "/thumbnail.png", std::string("\x89PNG\0\0", 6));
  write_text(folder + "/empty.log", "");
  std::filesystem::create_directory(folder + "/more.dcm");
  std::filesystem::create_symlink("nowhere", folder + "/.#7_0.dcm");
  ASSERT_EQ(mkfifo((folder + "/pipe.dcm").c_str(), 0600), 0);
  std::filesystem::copy(folder + "/7_0.dcm", folder + "/report.dcm");
  edit(folder + "/report.dcm", [](gdcm::DataSet& set) {
    set.Remove(kPixels);
    set_text(set, kSeriesUid, gdcm::VR::UI, "1.2.3");
  });
  std::filesystem::copy(folder + "/7_0.dcm", folder + "/scout.dcm");
  edit(folder + "/scout.dcm", [](gdcm::DataSet& set) {
    set_text(set, gdcm::Tag(0x0008, 0x0008), gdcm::VR::CS, "ORIGINAL\\PRIMARY\\LOCALIZER");
    set_text(set, kSeriesUid, gdcm::VR::UI, "1.2.4");
  });
  EXPECT_EQ(read_segmentation(folder).geometry.size, geometry.size);
}

TEST(DicomFolder, SlicesBehindLinks) {
  const Scratch scratch;
  const Geometry geometry = write_slices(scratch / "store");
  std::filesystem::create_directory(scratch / "series");
  for (int k = 0; k < 6; ++k) {
    const std::string name = "/7_" + std::to_string(k) + ".dcm";
    std::filesystem::create_symlink("../store" + name, scratch / "series" + name);
  }
  EXPECT_EQ(read_segmentation(scratch / "series").geometry.size, geometry.size);
  std::filesystem::remove(scratch / "store/7_4.dcm");
  EXPECT_THAT(dicom_error_of(scratch / "series"), HasSubstr("7_4.dcm: this link leads to no file"));
}

TEST(DicomFolder, WhatCannotBeReadIsNamed) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  write_slices(folder);
  chmod((scratch / "").c_str(), 0755);
  chmod((folder + "/7_4.dcm").c_str(), 0);
  {
    const AsNobody nobody;
    EXPECT_THAT(dicom_error_of(folder),
                HasSubstr("7_4.dcm: the file cannot be read; make it readable"));
  }
  chmod(folder.c_str(), 0);
  {
    const AsNobody nobody;
    EXPECT_THAT(dicom_error_of(folder),
                HasSubstr("series: the folder cannot be read: Permission denied"));
  }
  chmod(folder.c_str(), 0755);
}

TEST(DicomFolder, LastSliceCutAnywhere) {
  const Scratch scratch;
  const std::string folder = scratch / "series", last = folder + "/7_4.dcm";
  write_slices(folder);
  const std::string bytes = read_text(last);
  for (std::size_t size = 0; size < bytes.size(); size += 23) {
    write_text(last, bytes.substr(0, size));
    EXPECT_THAT(dicom_error_of(folder), HasSubstr("7_4.dcm: ")) << size;
  }
}

TEST(DicomFolder, SliceWithoutPixels) {
  const Scratch scratch;
  write_slices(scratch / "series");
  edit(scratch / "series/7_4.dcm", [](gdcm::DataSet& set) { set.Remove(kPixels); });
  EXPECT_THAT(dicom_error_of(scratch / "series"),
              HasSubstr("7_4.dcm: it belongs to the series but holds"));
  for (int k = 0; k < 6; ++k)
    if (k != 4) std::filesystem::remove(scratch / ("series/7_" + std::to_string(k) + ".dcm"));
  EXPECT_THAT(dicom_error_of(scratch / "series"), HasSubstr("7_4.dcm: it holds no pixels"));
}

TEST(DicomFolder, EmptyOrForeignFileNamedAsASlice) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  write_slices(folder);
  write_text(folder + "/7_6.DCM", "text");
  EXPECT_THAT(dicom_error_of(folder),
              HasSubstr("7_6.DCM: a file among the slices that is not DICOM"));
  std::filesystem::remove(folder + "/7_6.DCM");
  for (int k = 0; k < 6; ++k) {
    const std::string stem = folder + "/7_" + std::to_string(k);
    std::filesystem::rename(stem + ".dcm", stem);
  }
  EXPECT_EQ(read_segmentation(folder).geometry.size[2], 6);
  write_text(folder + "/7_6", "");
  EXPECT_THAT(dicom_error_of(folder), HasSubstr("7_6: an empty file among the slices"));
}

}  // namespace
}  // namespace vasamesh

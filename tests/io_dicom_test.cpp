/// \file
/// DICOM series: written through ITK and GDCM, then read from their folder.

#include <gdcmItem.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImageSeriesWriter.h>
#include <itkMetaDataObject.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
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

/// Six slices in `folder`; the last is 7_4.dcm. \return their geometry
Geometry write_slices(const std::string& folder) {
  const Geometry geometry = series_geometry(false);
  write_series(folder, geometry, random_pixels(geometry, 1), "7");
  return geometry;
}

/// Changes the elements of a file.
void edit(const std::string& path, const std::function<void(gdcm::DataSet&)>& change) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  ASSERT_TRUE(reader.Read());
  change(reader.GetFile().GetDataSet());
  gdcm::Writer writer;
  writer.CheckFileMetaInformationOff();
  writer.SetFile(reader.GetFile());
  writer.SetFileName(path.c_str());
  ASSERT_TRUE(writer.Write());
}

/// Sets an element of text.
void set_text(gdcm::DataSet& set, const gdcm::Tag& tag, const gdcm::VR& vr, std::string text) {
  if (text.size() % 2 != 0) text += ' ';
  gdcm::DataElement element(tag);
  element.SetVR(vr);
  element.SetByteValue(text.data(), static_cast<std::uint32_t>(text.size()));
  set.Replace(element);
}

const gdcm::Tag kSeriesUid(0x0020, 0x000e), kPixels(0x7fe0, 0x0010), kSpacing(0x0028, 0x0030);
const gdcm::Tag kPosition(0x0020, 0x0032), kOrientation(0x0020, 0x0037);

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

TEST(Dicom, WhatIsNoSliceIsLeftAside) {
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

TEST(Dicom, SlicesBehindLinks) {
  const Scratch scratch;
  const Geometry geometry = write_slices(scratch / "store");
  std::filesystem::create_directory(scratch / "series");
  for (int k = 0; k < 6; ++k) {
    const std::string name = "/7_" + std::to_string(k) + ".dcm";
    std::filesystem::create_symlink("../store" + name, scratch / "series" + name);
  }
  EXPECT_EQ(read_segmentation(scratch / "series").geometry.size, geometry.size);
  std::filesystem::remove(scratch / "store/7_4.dcm");
  EXPECT_THAT(error_of(scratch / "series"), HasSubstr("7_4.dcm: this link leads to no file"));
}

TEST(Dicom, WhatCannotBeReadIsNamed) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  write_slices(folder);
  chmod((scratch / "").c_str(), 0755);
  chmod((folder + "/7_4.dcm").c_str(), 0);
  {
    const AsNobody nobody;
    EXPECT_THAT(error_of(folder), HasSubstr("7_4.dcm: the file cannot be read; make it readable"));
  }
  chmod(folder.c_str(), 0);
  {
    const AsNobody nobody;
    EXPECT_THAT(error_of(folder),
                HasSubstr("series: the folder cannot be read: Permission denied"));
  }
  chmod(folder.c_str(), 0755);
}

TEST(Dicom, LastSliceCutAnywhere) {
  const Scratch scratch;
  const std::string folder = scratch / "series", last = folder + "/7_4.dcm";
  write_slices(folder);
  const std::string bytes = read_text(last);
  for (std::size_t size = 0; size < bytes.size(); size += 23) {
    write_text(last, bytes.substr(0, size));
    EXPECT_THAT(error_of(folder), HasSubstr("7_4.dcm: ")) << size;
  }
}

TEST(Dicom, SliceWithoutPixels) {
  const Scratch scratch;
  write_slices(scratch / "series");
  edit(scratch / "series/7_4.dcm", [](gdcm::DataSet& set) { set.Remove(kPixels); });
  EXPECT_THAT(error_of(scratch / "series"),
              HasSubstr("7_4.dcm: it belongs to the series but holds"));
}

TEST(Dicom, EmptyOrForeignFileNamedAsASlice) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  write_slices(folder);
  write_text(folder + "/7_6.DCM", "text");
  EXPECT_THAT(error_of(folder), HasSubstr("7_6.DCM: a file among the slices that is not DICOM"));
  std::filesystem::remove(folder + "/7_6.DCM");
  for (int k = 0; k < 6; ++k) {
    const std::string stem = folder + "/7_" + std::to_string(k);
    std::filesystem::rename(stem + ".dcm", stem);
  }
  EXPECT_EQ(read_segmentation(folder).geometry.size[2], 6);
  write_text(folder + "/7_6", "");
  EXPECT_THAT(error_of(folder), HasSubstr("7_6: an empty file among the slices"));
}

/// Replaces an element of the decimal strings `text` in a slice.
void set_decimals(const std::string& path, const gdcm::Tag& tag, const std::string& text) {
  edit(path, [&](gdcm::DataSet& set) { set_text(set, tag, gdcm::VR::DS, text); });
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
    EXPECT_THAT(error_of(scratch / "series"),
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
  EXPECT_THAT(error_of(scratch / "series"), HasSubstr("mm within its plane"));
}

TEST(Dicom, PixelSpacingMissingOrZero) {
  const Scratch scratch;
  const std::string folder = scratch / "series", slice = folder + "/7_2.dcm";
  write_slices(folder);
  edit(slice, [](gdcm::DataSet& set) { set.Remove(kSpacing); });
  EXPECT_THAT(error_of(folder), HasSubstr("7_2.dcm: it has no PixelSpacing (0028,0030); add it"));
  set_decimals(slice, gdcm::Tag(0x0018, 0x1164), "0.7\\0.7");
  EXPECT_THAT(error_of(folder),
              HasSubstr("7_2.dcm: it has no PixelSpacing (0028,0030), only Imager"));
  set_decimals(slice, kSpacing, "0\\0.7");
  EXPECT_THAT(error_of(folder),
              HasSubstr("its PixelSpacing (0028,0030) is 0 x 0.7 mm; correct it"));
}

TEST(Dicom, PositionsMissingOrTheSame) {
  const Scratch scratch;
  const std::string folder = scratch / "series";
  const Geometry geometry = write_slices(folder);
  edit(folder + "/7_2.dcm", [](gdcm::DataSet& set) { set.Remove(kPosition); });
  EXPECT_THAT(error_of(folder), HasSubstr("7_2.dcm: this slice has no position (ImagePosition"));
  for (int k = 0; k < 6; ++k)
    set_decimals(folder + "/7_" + std::to_string(k) + ".dcm", kPosition, decimals(geometry.origin));
  EXPECT_THAT(error_of(folder), HasSubstr("its slices have no positions of their own"));
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
  EXPECT_THAT(error_of(scratch / "series"),
              ::testing::AllOf(HasSubstr("copy.dcm: this slice lies where that of "),
                               HasSubstr("7_2.dcm lies; give one volume, with every slice once")));
}

TEST(Dicom, OrientationThatIsNone) {
  const Scratch scratch;
  write_slices(scratch / "series");
  set_decimals(scratch / "series/7_2.dcm", kOrientation, "1\\0\\0\\0.2\\1\\0");
  EXPECT_THAT(error_of(scratch / "series"),
              HasSubstr("7_2.dcm: this slice has an ImageOrientationPatient that is not two"));
}

TEST(Dicom, SlicesThatDiffer) {
  const Scratch scratch;
  write_slices(scratch / "series");
  set_decimals(scratch / "series/7_2.dcm", kSpacing, "0.7\\0.8");
  EXPECT_THAT(
      error_of(scratch / "series"),
      HasSubstr("7_2.dcm: this slice differs in size, spacing or orientation from the first"));
}

/// A sequence of `items` as an element of `set`.
void set_items(gdcm::DataSet& set, const gdcm::Tag& tag, const std::vector<gdcm::DataSet>& items) {
  gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = new gdcm::SequenceOfItems;
  sequence->SetLengthToUndefined();
  for (const gdcm::DataSet& nested : items) {
    gdcm::Item item;
    item.SetVLToUndefined();
    item.SetNestedDataSet(nested);
    sequence->AddItem(item);
  }
  gdcm::DataElement element(tag);
  element.SetVR(gdcm::VR::SQ);
  element.SetValue(*sequence);
  element.SetVLToUndefined();
  set.Replace(element);
}

gdcm::DataSet one_decimals(const gdcm::Tag& tag, const std::string& text) {
  gdcm::DataSet set;
  set_text(set, tag, gdcm::VR::DS, text);
  return set;
}

/// What a file of several frames holds.
struct Frames {
  Geometry geometry = series_geometry(false);
  std::vector<std::int16_t> pixels = random_pixels(geometry, 1);
  std::vector<std::array<double, 3>> positions = {};  ///< of each frame
  std::vector<std::uint16_t> segments = {};           ///< none, or of each frame
};

/// Frame k of the file is slice order[k].
Frames frames_in_order(const std::vector<int>& order) {
  Frames frames;
  const auto pixels = frames.pixels;
  frames.pixels.clear();
  for (const int k : order) {
    auto position = frames.geometry.origin;
    position[2] += 1.25 * k;
    frames.positions.push_back(position);
    frames.pixels.insert(frames.pixels.end(), pixels.begin() + 357 * k,
                         pixels.begin() + 357 * (k + 1));
  }
  return frames;
}

gdcm::DataSet groups_of_frame(const Frames& frames, std::size_t k) {
  gdcm::DataSet groups;
  set_items(groups, gdcm::Tag(0x0020, 0x9113),
            {one_decimals(kPosition, decimals(frames.positions[k]))});
  if (frames.segments.empty()) return groups;
  gdcm::DataElement number(gdcm::Tag(0x0062, 0x000b));
  number.SetVR(gdcm::VR::US);
  number.SetByteValue(reinterpret_cast<const char*>(&frames.segments[k]), 2);
  gdcm::DataSet segment;
  segment.Insert(number);
  set_items(groups, gdcm::Tag(0x0062, 0x000a), {segment});
  return groups;
}

/// Writes one file of several frames into `folder`.
void write_frames(const std::string& folder, const Frames& frames) {
  Geometry slice = frames.geometry;
  slice.size[2] = 1;
  write_series(folder, slice, random_pixels(slice, 1), "7");
  edit(folder + "/7_0.dcm", [&](gdcm::DataSet& set) {
    const auto take = [&](const gdcm::Tag& tag) {
      gdcm::DataSet one;
      one.Insert(set.GetDataElement(tag));
      set.Remove(tag);
      return one;
    };
    gdcm::DataSet shared;
    set_items(shared, gdcm::Tag(0x0020, 0x9116), {take(kOrientation)});
    set_items(shared, gdcm::Tag(0x0028, 0x9110), {take(kSpacing)});
    set_items(set, gdcm::Tag(0x5200, 0x9229), {shared});
    std::vector<gdcm::DataSet> groups;
    for (std::size_t k = 0; k < frames.positions.size(); ++k)
      groups.push_back(groups_of_frame(frames, k));
    if (!groups.empty()) set_items(set, gdcm::Tag(0x5200, 0x9230), groups);
    set.Remove(kPosition);
    set_text(set, gdcm::Tag(0x0028, 0x0008), gdcm::VR::IS,
             std::to_string(frames.pixels.size() / 357));
    gdcm::DataElement pixels(kPixels);
    pixels.SetVR(gdcm::VR::OW);
    pixels.SetByteValue(reinterpret_cast<const char*>(frames.pixels.data()),
                        static_cast<std::uint32_t>(2 * frames.pixels.size()));
    set.Replace(pixels);
  });
}

TEST(Dicom, FramesInAnyOrderArePlaced) {
  const Geometry geometry = series_geometry(false);
  const auto pixels = random_pixels(geometry, 1);
  for (const std::vector<int>& order :
       {std::vector<int>{0, 1, 2, 3, 4, 5}, {5, 4, 3, 2, 1, 0}, {3, 0, 5, 1, 4, 2}}) {
    const Scratch scratch;
    write_frames(scratch / "series", frames_in_order(order));
    const Segmentation read = read_segmentation(scratch / "series");
    EXPECT_EQ(read.geometry.size, geometry.size);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(read.geometry.spacing[a], geometry.spacing[a], 1e-6);
      EXPECT_NEAR(read.geometry.origin[a], geometry.origin[a], 1e-6);
    }
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_NEAR(read.geometry.direction[i], geometry.direction[i], 1e-6);
    EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), read.voxels.begin(), read.voxels.end()));
  }
}

TEST(Dicom, FramesThatCannotBePlaced) {
  const Scratch scratch;
  Frames frames = frames_in_order({0, 1, 2, 3, 4, 5});
  frames.positions.clear();
  write_frames(scratch / "none", frames);
  EXPECT_THAT(error_of(scratch / "none"), HasSubstr("7_0.dcm: the positions of its 6 frames are "));
  frames.positions.resize(4);
  write_frames(scratch / "some", frames);
  EXPECT_THAT(error_of(scratch / "some"), HasSubstr("holds 6 frames and describes 4"));
  frames = frames_in_order({0, 1, 2, 3, 4, 5});
  for (std::size_t k = 3; k < 6; ++k) frames.positions[k][2] += 5;
  write_frames(scratch / "uneven", frames);
  EXPECT_THAT(error_of(scratch / "uneven"),
              HasSubstr("7_0.dcm: its frame 4 is 6.25 mm from the one before, others 1.25 mm"));
  frames = frames_in_order({0, 1, 2, 3, 4, 5});
  frames.positions[2][0] += 3;
  write_frames(scratch / "jump", frames);
  EXPECT_THAT(error_of(scratch / "jump"), HasSubstr("its frame 3 is displaced by 3 mm within"));
  write_frames(scratch / "twice", frames_in_order({0, 1, 2, 3, 4, 2}));
  EXPECT_THAT(error_of(scratch / "twice"), HasSubstr("its frame 6 lies where its frame 3 lies"));
}

TEST(Dicom, SeveralSegments) {
  const Scratch scratch;
  Frames frames = frames_in_order({0, 1, 2, 0, 1, 2});
  frames.segments = {1, 1, 1, 2, 2, 2};
  write_frames(scratch / "series", frames);
  EXPECT_THAT(error_of(scratch / "series"),
              HasSubstr("7_0.dcm: it holds 2 segments; export one segment alone"));
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

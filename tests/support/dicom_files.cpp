#include "support/dicom_files.h"

#include <gdcmItem.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImageSeriesWriter.h>
#include <itkMetaDataObject.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>

#include "io/volume_reader.h"
#include "support/itk_volumes.h"
#include "vasamesh/errors.h"

namespace vasamesh {

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

std::string decimals(const double* values, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    char digits[32];
    std::snprintf(digits, sizeof(digits), "%.9g", values[i]);
    if (!text.empty()) text += '\\';
    text += digits;
  }
  return text;
}

namespace {

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

}  // namespace

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

Geometry write_slices(const std::string& folder) {
  const Geometry geometry = series_geometry(false);
  write_series(folder, geometry, random_pixels(geometry, 1), "7");
  return geometry;
}

void edit_file(const std::string& path, const std::function<void(gdcm::File&)>& change) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  ASSERT_TRUE(reader.Read());
  change(reader.GetFile());
  gdcm::Writer writer;
  writer.SetFile(reader.GetFile());
  writer.SetFileName(path.c_str());
  ASSERT_TRUE(writer.Write());
}

void edit(const std::string& path, const std::function<void(gdcm::DataSet&)>& change) {
  edit_file(path, [&](gdcm::File& file) { change(file.GetDataSet()); });
}

void set_text(gdcm::DataSet& set, const gdcm::Tag& tag, const gdcm::VR& vr, std::string text) {
  if (text.size() % 2 != 0) text += ' ';
  gdcm::DataElement element(tag);
  element.SetVR(vr);
  element.SetByteValue(text.data(), static_cast<std::uint32_t>(text.size()));
  set.Replace(element);
}

void set_unsigned(gdcm::DataSet& set, const gdcm::Tag& tag, std::uint16_t value) {
  gdcm::DataElement element(tag);
  element.SetVR(gdcm::VR::US);
  element.SetByteValue(reinterpret_cast<const char*>(&value), sizeof(value));
  set.Replace(element);
}

void set_decimals(const std::string& path, const gdcm::Tag& tag, const std::string& text) {
  edit(path, [&](gdcm::DataSet& set) { set_text(set, tag, gdcm::VR::DS, text); });
}

namespace {

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

}  // namespace

DicomFrames frames_in_order(const std::vector<int>& order) {
  DicomFrames frames;
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

namespace {

gdcm::DataSet groups_of_frame(const DicomFrames& frames, std::size_t k) {
  gdcm::DataSet groups;
  set_items(groups, gdcm::Tag(0x0020, 0x9113),
            {one_decimals(kPosition, decimals(frames.positions[k]))});
  if (frames.segments.empty()) return groups;
  gdcm::DataSet segment;
  set_unsigned(segment, gdcm::Tag(0x0062, 0x000b), frames.segments[k]);
  set_items(groups, gdcm::Tag(0x0062, 0x000a), {segment});
  return groups;
}

}  // namespace

void write_frames(const std::string& folder, const DicomFrames& frames) {
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
             std::to_string(frames.pixels.size() /
                            static_cast<std::size_t>(slice.size[0] * slice.size[1])));
    gdcm::DataElement pixels(kPixels);
    pixels.SetVR(gdcm::VR::OW);
    pixels.SetByteValue(reinterpret_cast<const char*>(frames.pixels.data()),
                        static_cast<std::uint32_t>(2 * frames.pixels.size()));
    set.Replace(pixels);
  });
}

std::string dicom_error_of(const std::string& path) {
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

}  // namespace vasamesh

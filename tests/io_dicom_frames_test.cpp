/// \file
/// DICOM files of several frames.

#include <gdcmTransferSyntax.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "io/volume_reader.h"
#include "support/dicom_files.h"
#include "support/scratch.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

using ::testing::HasSubstr;

TEST(FramesOfDicom, InAnyOrderArePlaced) {
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

TEST(FramesOfDicom, ThatCannotBePlaced) {
  const Scratch scratch;
  DicomFrames frames = frames_in_order({0, 1, 2, 3, 4, 5});
  frames.positions.clear();
  write_frames(scratch / "none", frames);
  EXPECT_THAT(dicom_error_of(scratch / "none"),
              HasSubstr("7_0.dcm: the positions of its 6 frames are "));
  frames.positions.resize(4);
  write_frames(scratch / "some", frames);
  EXPECT_THAT(dicom_error_of(scratch / "some"), HasSubstr("holds 6 frames and describes 4"));
  frames = frames_in_order({0, 1, 2, 3, 4, 5});
  for (std::size_t k = 3; k < 6; ++k) frames.positions[k][2] += 5;
  write_frames(scratch / "uneven", frames);
  EXPECT_THAT(dicom_error_of(scratch / "uneven"),
              HasSubstr("7_0.dcm: its frame 4 is 6.25 mm from the one before, others 1.25 mm"));
  frames = frames_in_order({0, 1, 2, 3, 4, 5});
  frames.positions[2][0] += 3;
  write_frames(scratch / "jump", frames);
  EXPECT_THAT(dicom_error_of(scratch / "jump"),
              HasSubstr("its frame 3 is displaced by 3 mm within"));
  write_frames(scratch / "twice", frames_in_order({0, 1, 2, 3, 4, 2}));
  EXPECT_THAT(dicom_error_of(scratch / "twice"),
              HasSubstr("its frame 6 lies where its frame 3 lies"));
}

TEST(FramesOfDicom, SeveralSegments) {
  const Scratch scratch;
  DicomFrames frames = frames_in_order({0, 1, 2, 0, 1, 2});
  frames.segments = {1, 1, 1, 2, 2, 2};
  write_frames(scratch / "series", frames);
  EXPECT_THAT(dicom_error_of(scratch / "series"),
              HasSubstr("7_0.dcm: it holds 2 segments; export one segment alone"));
}

/// Sets the pixels of a file to `bytes`.
void set_pixels(gdcm::DataSet& set, const std::vector<char>& bytes) {
  gdcm::DataElement pixels(kPixels);
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetByteValue(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  set.Replace(pixels);
}

void set_bits(gdcm::DataSet& set, std::uint16_t bits) {
  set_unsigned(set, gdcm::Tag(0x0028, 0x0100), bits);
  set_unsigned(set, gdcm::Tag(0x0028, 0x0101), bits);
  set_unsigned(set, gdcm::Tag(0x0028, 0x0102), static_cast<std::uint16_t>(bits - 1));
  set_unsigned(set, gdcm::Tag(0x0028, 0x0103), 0);
}

TEST(FramesOfDicom, VoxelsOfOneBit) {
  const Scratch scratch;
  const DicomFrames frames = frames_in_order({5, 4, 3, 2, 1, 0});
  write_frames(scratch / "series", frames);
  edit(scratch / "series/7_0.dcm", [&](gdcm::DataSet& set) {
    std::vector<char> bytes((frames.pixels.size() + 15) / 16 * 2);
    for (std::size_t i = 0; i < frames.pixels.size(); ++i)
      bytes[i / 8] = static_cast<char>(bytes[i / 8] | frames.pixels[i] << i % 8);
    set_bits(set, 1);
    set_pixels(set, bytes);
  });
  const auto pixels = random_pixels(frames.geometry, 1);
  const Segmentation read = read_segmentation(scratch / "series");
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), read.voxels.begin(), read.voxels.end()));
}

TEST(FramesOfDicom, MoreThanIsAllowedInMemory) {
  const Scratch scratch;
  write_frames(scratch / "series", frames_in_order({0, 1, 2, 3, 4, 5}));
  try {
    read_segmentation(scratch / "series", {.max_memory = 4283});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::refused);
    EXPECT_THAT(error.what(),
                HasSubstr("7_0.dcm: it needs 4284 bytes of memory, 4283 are allowed"));
  }
}

/// Deflates a file; GDCM's own writer fails where there is much.
void deflate_file(const std::string& path) {
  edit_file(path, [](gdcm::File& file) {
    file.GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
  });
  std::string bytes = read_text(path);
  constexpr std::size_t kMetaLength = 140;  // where the length of the rest of group 0002 stands
  const std::string syntax(
      "\2\0\x10\0UI\x14\0"
      "1.2.840.10008.1.2.1\0",
      28);
  const std::string deflated(
      "\2\0\x10\0UI\x16\0"
      "1.2.840.10008.1.2.1.99",
      30);
  bytes.replace(bytes.find(syntax), syntax.size(), deflated);
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes[kMetaLength], sizeof(length));
  length += 2;
  std::memcpy(&bytes[kMetaLength], &length, sizeof(length));
  const std::size_t begin = kMetaLength + sizeof(length) + length;
  std::vector<Bytef> packed(compressBound(bytes.size()));
  z_stream stream{};
  ASSERT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data() + begin);
  stream.avail_in = static_cast<uInt>(bytes.size() - begin);
  stream.next_out = packed.data();
  stream.avail_out = static_cast<uInt>(packed.size());
  ASSERT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  write_text(path, bytes.substr(0, begin) +
                       std::string(reinterpret_cast<const char*>(packed.data()), stream.total_out));
  deflateEnd(&stream);
}

TEST(FramesOfDicom, FewBytesOfManyVoxels) {  // 168 MB in 170 kB
  const Scratch scratch;
  constexpr std::size_t kCount = 320, kFrame = 512 * 512;
  DicomFrames frames;
  frames.geometry.size = {512, 512, kCount};
  frames.pixels.assign(kFrame * kCount, 0);
  std::fill_n(frames.pixels.begin() + 100 * kFrame, 1000, std::int16_t{1});
  for (std::size_t k = 0; k < kCount; ++k) {
    frames.positions.push_back(frames.geometry.origin);
    frames.positions.back()[2] += 1.25 * static_cast<double>(k);
  }
  write_frames(scratch / "series", frames);
  deflate_file(scratch / "series/7_0.dcm");
  EXPECT_LT(std::filesystem::file_size(scratch / "series/7_0.dcm"), 300'000u);
  const PackedSegmentation read = read_packed(scratch / "series");
  EXPECT_EQ(read.geometry.size, frames.geometry.size);
  std::size_t bits = 0;
  for (const std::uint8_t byte : read.bits) bits += static_cast<std::size_t>(std::popcount(byte));
  EXPECT_EQ(bits, 1000u);
}

}  // namespace
}  // namespace vasamesh

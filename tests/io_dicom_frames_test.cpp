/// \file
/// DICOM files of several frames.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "io/volume_reader.h"
#include "support/dicom_files.h"
#include "support/scratch.h"

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

}  // namespace
}  // namespace vasamesh

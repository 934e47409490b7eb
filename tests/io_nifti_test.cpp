/// \file
/// NIfTI in: where it is placed, units, byte order, rescaling.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "io/volume_reader.h"
#include "support/geometries.h"
#include "support/itk_volumes.h"
#include "support/scratch.h"
#include "support/volume_files.h"

namespace vasamesh {
namespace {

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

}  // namespace
}  // namespace vasamesh

/// \file
/// MetaImage and NRRD in: byte order, voxels in files of their own, fields, spaces and units.

#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>
#include <utility>

#include "io/volume_reader.h"
#include "support/geometries.h"
#include "support/scratch.h"
#include "support/volume_files.h"

namespace vasamesh {
namespace {

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

}  // namespace
}  // namespace vasamesh

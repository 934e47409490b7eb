/// \file
/// Spoiled files of every format: bytes turned, cut, put in and swapped, by fixed seeds. Each gives
/// a result or an Error; never a crash, another exception, or memory out of proportion.

#include <gdcmTrace.h>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImageFileWriter.h>
#include <itkMetaDataObject.h>
#include <sys/resource.h>

#include <filesystem>
#include <functional>
#include <random>

#include "io/surface_io.h"
#include "io/volume_reader.h"
#include "support/itk_volumes.h"
#include "support/leaks.h"
#include "support/scratch.h"
#include "support/volume_files.h"
#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

constexpr int kRounds = 300;

/// Of formats that are read on trial, in a process of its own.
constexpr int kSlowRounds = 80;

/// The most address space that reading may take beyond what the process has: whatever a header
/// says, an allocation past it fails and is seen.
constexpr rlim_t kMostBytes = rlim_t{4} << 30;

/// Turns, cuts, inserts or repeats a few bytes; the front of a file, its header, most of all.
std::string spoiled(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n ? random() % n : 0; };
  const auto position = [&] {
    return below(random() % 4 ? std::min<std::size_t>(bytes.size(), 400) : bytes.size());
  };
  for (std::size_t change = 1 + below(3); change > 0 && !bytes.empty(); --change) {
    const std::size_t at = position();
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(random());
        break;
      case 2:
        bytes[at] = "0189-+.eE \n:="[below(13)];
        break;
      case 3:
        bytes.resize(at);
        break;
      case 4:
        bytes.insert(at, bytes.substr(position(), below(40)));
        break;
      default:
        bytes.erase(at, below(20));
        break;
    }
  }
  return bytes;
}

/// Lowers the limit of address space for its lifetime.
class MemoryLimit {
 public:
  MemoryLimit() {
    getrlimit(RLIMIT_AS, &before_);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    const rlimit limit{kMostBytes, before_.rlim_max};
    setrlimit(RLIMIT_AS, &limit);
#endif
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};

using Spoil = std::function<std::string(const std::string&, std::mt19937&)>;

/// Reads `good`, then spoiled in so many ways.
void fuzz(const std::string& path, const std::string& good, const std::function<void()>& read,
          int rounds = kRounds, const Spoil& spoil = spoiled) {
  write_text(path, good);
  ASSERT_NO_THROW(read());
  const MemoryLimit limit;
  for (int round = 0; round < rounds; ++round) {
    std::mt19937 random(static_cast<unsigned>(round));
    write_text(path, spoil(good, random));
    try {
      read();
    } catch (const Error& error) {
      const bool expected =
          error.code() == ErrorCode::bad_input || error.code() == ErrorCode::refused;
      EXPECT_TRUE(expected) << "round " << round << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << round;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "round " << round << ": " << error.what();
    }
  }
}

Geometry small_geometry() {
  return {{7, 5, 3}, {0.5, 0.5, 0.75}, {1, 2, 3}, {0, 1, 0, 1, 0, 0, 0, 0, 1}};
}

std::vector<std::int16_t> small_pixels() {
  std::vector<std::int16_t> pixels(105, 0);
  for (std::size_t i = 0; i < pixels.size(); i += 4) pixels[i] = 1;
  return pixels;
}

class VolumeFuzz : public ::testing::TestWithParam<std::pair<const char*, bool>> {};

TEST_P(VolumeFuzz, IsReadOrRefused) {
  const auto [name, compress] = GetParam();
  const Scratch scratch;
  const std::string path = scratch / name;
  write_itk(path, small_geometry(), small_pixels(), compress);
  fuzz(path, read_text(path), [&] { read_segmentation(path, {.label = 1}); });
}

INSTANTIATE_TEST_SUITE_P(Formats, VolumeFuzz,
                         ::testing::Values(std::pair{"a.nii", false}, std::pair{"a.nii.gz", true},
                                           std::pair{"a.mha", false}, std::pair{"a.mha", true},
                                           std::pair{"a.mhd", false}, std::pair{"a.nrrd", false},
                                           std::pair{"a.nrrd", true}));

// The checksum hides a compressed header from most of the above.
TEST(VolumeFuzzInside, CompressedNifti) {
  const Scratch scratch;
  const std::string path = scratch / "a.nii.gz";
  const std::string good = nifti_file(nifti_header(7, 5, 3), std::string(105, '\1'));
  int read = 0;
  const auto count_read = [&] {
    read_segmentation(path);
    ++read;
  };
  fuzz(path, gzip(good), count_read, kRounds,
       [&](const std::string&, std::mt19937& random) { return gzip(spoiled(good, random)); });
  EXPECT_GT(read, 1);  // beside the good one
  EXPECT_LE(read, kRounds);
}

TEST(DicomFuzz, IsReadOrRefused) {
  const Scratch scratch;
  gdcm::Trace::WarningOff();
  std::filesystem::create_directory(scratch / "series");
  const std::string path = scratch / "series/a.dcm";
  using Slice = itk::Image<std::int16_t, 2>;
  auto slice = Slice::New();
  slice->SetRegions(Slice::SizeType{{7, 5}});
  slice->Allocate();
  slice->FillBuffer(1);
  itk::EncapsulateMetaData<std::string>(slice->GetMetaDataDictionary(), "0008|0060", "CT");
  auto writer = itk::ImageFileWriter<Slice>::New();
  writer->SetImageIO(itk::GDCMImageIO::New());
  writer->SetFileName(path);
  writer->SetInput(slice);
  writer->Update();
  fuzz(
      path, read_text(path), [&] { read_segmentation(scratch / "series", {.label = 1}); }, 100);
}

class SurfaceFuzz : public ::testing::TestWithParam<const char*> {};

TEST_P(SurfaceFuzz, IsReadOrRefused) {
  const Scratch scratch;
  const std::string path = scratch / GetParam();
  const TriangleMesh tetrahedron{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
                                 {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}};
  write_surface(path, tetrahedron, Space::lps);
  fuzz(
      path, read_text(path), [&] { read_surface(path); }, kSlowRounds);
}

INSTANTIATE_TEST_SUITE_P(Formats, SurfaceFuzz,
                         ::testing::Values("a.vtp", "a.stl", "a.ply", "a.obj"));

TEST(SurfaceFuzzText, IsReadOrRefused) {
  const Scratch scratch;
  const std::pair<const char*, const char*> files[] = {
      {"a.vtk",
       "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
       "0 0 0 1 0 0 1 1 0 0 1 0\nPOLYGONS 1 5\n4 0 1 2 3\n"},
      {"a.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n1 0 0\n0 1 0\n3 2 0 1\n"},
      {"a.stl",
       "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid x\n"}};
  for (const auto& [name, good] : files) {
    SCOPED_TRACE(name);
    const std::string path = scratch / name;
    fuzz(
        path, good, [&] { read_surface(path); }, kSlowRounds);
  }
}

}  // namespace
}  // namespace vasamesh

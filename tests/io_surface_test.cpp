/// \file
/// Surfaces out and in: the same float bits in every format, the space in the file, other programs'
/// files, and bad ones.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

#include "support/surface_files.h"

namespace vasamesh {
namespace {

using ::testing::HasSubstr;

std::vector<std::uint32_t> bits(const std::vector<float>& values) {
  std::vector<std::uint32_t> words(values.size());
  std::memcpy(words.data(), values.data(), values.size() * sizeof(float));
  return words;
}

/// The corners' coordinates, triangle by triangle.
std::vector<float> corners(const TriangleMesh& mesh) {
  std::vector<float> out;
  for (const std::uint32_t corner : mesh.triangles) {
    out.insert(out.end(), &mesh.vertices[3 * corner], &mesh.vertices[3 * corner] + 3);
  }
  return out;
}

TEST_F(Surfaces, TheSameBitsInEveryFormat) {
  const TriangleMesh mesh = random_mesh(1237);
  for (const char* name : kFormats) {
    SCOPED_TRACE(name);
    write_surface(scratch_ / name, mesh, Space::lps);
    const TriangleMesh read = read_surface(scratch_ / name);
    EXPECT_EQ(read.vertex_count(), mesh.vertex_count());
    EXPECT_EQ(bits(corners(read)), bits(corners(mesh)));
    if (std::string(name) == "a.stl") continue;  // has no indices of its own
    EXPECT_EQ(bits(read.vertices), bits(mesh.vertices));
    EXPECT_EQ(read.triangles, mesh.triangles);
  }
}

TEST_F(Surfaces, StlVerticesAreMergedInOrderOfAppearance) {
  write_surface(scratch_ / "a.stl", tetrahedron(), Space::lps);
  const TriangleMesh read = read_surface(scratch_ / "a.stl");
  EXPECT_EQ(read.vertices, (std::vector<float>{0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(read.triangles, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 2, 1, 3, 0, 3, 1}));
}

TEST_F(Surfaces, StlVerticesOfMinusZeroAreThoseOfZero) {
  write_surface(scratch_ / "a.stl", tetrahedron(), Space::lps);
  std::string bytes = read_text(scratch_ / "a.stl");
  const float zero = -0.0f;
  std::memcpy(&bytes[84 + 12], &zero, sizeof(zero));
  EXPECT_EQ(read_surface(write("a.stl", bytes)).vertex_count(), 4u);
}

TEST_F(Surfaces, BinaryStlThatBeginsAsText) {
  write_surface(scratch_ / "a.stl", tetrahedron(), Space::lps);
  const std::string plain = read_text(scratch_ / "a.stl");
  for (const char filling : {'\0', ' '}) {
    std::string bytes = plain;
    bytes.replace(0, 80, "solid" + std::string(75, filling));
    EXPECT_EQ(read_surface(write("a.stl", bytes)).triangle_count(), 4u);
    expect_bad(write("a.stl", bytes.substr(0, bytes.size() - 20)), "truncated");
    bytes.replace(80, 4, "\xff\xff\xff\xff");
    expect_bad(write("a.stl", bytes), "truncated");
  }
}

TEST_F(Surfaces, TextStl) {
  const std::string facet =
      "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 -0\n"
      " endloop\nendfacet\n";
  for (const char* name : {"", " of no length in particular", " caf\xc3\xa9"})
    EXPECT_EQ(
        read_surface(write("a.stl", "solid" + std::string(name) + "\n" + facet + "endsolid\n"))
            .triangle_count(),
        1u);
}

TEST_F(Surfaces, TextStlInOtherSpellings) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex +1.5e0 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\n";
  const std::string text = "solid x\n" + facet + "endsolid x\n";
  std::string upper = text;
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string old_mac = text;
  std::replace(old_mac.begin(), old_mac.end(), '\n', '\r');
  for (const std::string& file :
       {text, upper, "  " + text, "\n\n" + text, "\xef\xbb\xbf" + text, old_mac,
        "solid " + std::string(3000, 'n') + "\n" + facet + "endsolid\n",
        "solid facet loop vertex 1\n" + facet + "endsolid loop\n"})
    EXPECT_EQ(read_surface(write("a.stl", file)).vertices,
              (std::vector<float>{0, 0, 0, 1.5f, 0, 0, 0, 1, 0}))
        << file.substr(0, 40);
  EXPECT_EQ(read_surface(write("a.stl", text + text)).triangle_count(), 2u);
  for (const char* missing : {"vertex 0 1 0\n", "endsolid x\n", " 1 0\nendloop"}) {
    std::string file = text;
    expect_bad(write("a.stl", file.erase(file.find(missing), std::strlen(missing))), "truncated");
  }
}

TEST_F(Surfaces, ABinaryStlHoldsAsManyTrianglesAsItSays) {
  write_surface(scratch_ / "a.stl", tetrahedron(), Space::lps);
  const std::string plain = read_text(scratch_ / "a.stl");
  const auto said = [&](char count, const std::string& tail) {
    std::string bytes = plain + tail;
    bytes[80] = count;
    return write("a.stl", bytes);
  };
  for (const std::size_t tail : {0, 1, 50, 100})
    EXPECT_EQ(read_surface(said(4, std::string(tail, 'x'))).triangle_count(), 4u) << tail;
  EXPECT_EQ(read_surface(said(3, "")).triangle_count(), 3u);
  EXPECT_EQ(read_surface(said(0, "")).triangle_count(), 4u);
  expect_bad(said(5, "x"), "truncated");
}

TEST_F(Surfaces, TheSpaceIsInTheFile) {
  const std::pair<Space, std::string> spaces[] = {
      {Space::lps, "LPS"}, {Space::ras, "RAS"}, {Space::voxel, "VOXEL"}};
  for (const auto& [space, name] : spaces) {
    for (const char* file : kFormats) write_surface(scratch_ / file, tetrahedron(), space);
    EXPECT_THAT(read_text(scratch_ / "a.stl").substr(0, 80), HasSubstr("SPACE=" + name));
    EXPECT_THAT(read_text(scratch_ / "a.ply"), HasSubstr("comment SPACE=" + name + "\n"));
    EXPECT_THAT(read_text(scratch_ / "a.obj"), HasSubstr("# SPACE=" + name + "\n"));
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName((scratch_ / "a.vtp").c_str());
    reader->Update();
    const auto* array = vtkStringArray::SafeDownCast(
        reader->GetOutput()->GetFieldData()->GetAbstractArray("SPACE"));
    ASSERT_NE(array, nullptr);
    EXPECT_EQ(const_cast<vtkStringArray*>(array)->GetValue(0), name);
    for (const char* file : kFormats)
      EXPECT_EQ(read_placed_surface(scratch_ / file).space, space) << file;
  }
}

TEST_F(Surfaces, TheSpaceInOtherProgramsFiles) {
  const std::string facets = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto space_of = [&](const std::string& head) {
    return read_placed_surface(write("b.obj", head + facets)).space;
  };
  EXPECT_EQ(space_of("# 3D Slicer output. SPACE=RAS\n"), Space::ras);
  EXPECT_EQ(space_of("# SPACE=unknown\n"), std::nullopt);
  EXPECT_EQ(space_of(""), std::nullopt);
  const std::string legacy =
      "# vtk DataFile Version 4.2\n3D Slicer output. SPACE=LPS\nASCII\nDATASET POLYDATA\n"
      "POINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n";
  EXPECT_EQ(read_placed_surface(write("b.vtk", legacy)).space, Space::lps);
}

TEST_F(Surfaces, OtherProgramsReadThem) {
  const TriangleMesh mesh = random_mesh(101);
  write_surface(scratch_ / "a.stl", mesh, Space::lps);
  write_surface(scratch_ / "a.ply", mesh, Space::lps);
  vtkNew<vtkSTLReader> stl;
  stl->SetFileName((scratch_ / "a.stl").c_str());
  stl->Update();
  EXPECT_EQ(stl->GetOutput()->GetNumberOfPolys(), 99);
  vtkNew<vtkPLYReader> ply;
  ply->SetFileName((scratch_ / "a.ply").c_str());
  ply->Update();
  EXPECT_EQ(ply->GetOutput()->GetNumberOfPolys(), 99);
  EXPECT_EQ(ply->GetOutput()->GetNumberOfPoints(), 101);
}

TEST_F(Surfaces, FilesOfOtherPrograms) {
  const std::string obj =
      "# quads, normals and counting backwards\nvn 0 0 1\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0 1 0\n"
      "g one\nf 1//1 2//1 3//1 4//1\r\nv 0 0 1\nf -1/1 2 1/2/3\n";
  const TriangleMesh quad = read_surface(write("a.obj", obj));
  EXPECT_EQ(quad.vertex_count(), 5u);
  EXPECT_EQ(quad.triangles, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 4, 1, 0}));

  const std::string vtk =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 5 double\n"
      "0 0 0 1 0 0 1 1 0 0 1 0 2 2 2\nPOLYGONS 1 5\n4 0 1 2 3\nTRIANGLE_STRIPS 1 5\n4 0 1 3 4\n";
  EXPECT_EQ(read_surface(write("a.vtk", vtk)).triangles,
            (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 0, 1, 3, 1, 4, 3}));

  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 2 0 1\n";
  EXPECT_EQ(read_surface(write("a.ply", ply)).triangles, (std::vector<std::uint32_t>{2, 0, 1}));

  std::string big =
      "ply\nformat binary_big_endian 1.0\nelement junk 2\nproperty list uchar short more\n"
      "element vertex 3\nproperty uchar red\nproperty double y\nproperty float x\nproperty int z\n"
      "element face 1\nproperty uchar red\nproperty list ushort uchar vertex_index\nend_header\n";
  big += std::string("\0\1\0\7", 4);
  for (int i = 0; i < 3; ++i) big += std::string("r\x40\0\0\0\0\0\0\0\xbf\x80\0\0\0\0\1\0", 17);
  big += std::string("r\0\3\2\0\1", 6);
  const TriangleMesh mesh = read_surface(write("b.ply", big));
  EXPECT_EQ(mesh.vertices, (std::vector<float>{-1, 2, 256, -1, 2, 256, -1, 2, 256}));
  EXPECT_EQ(mesh.triangles, (std::vector<std::uint32_t>{2, 0, 1}));

  const std::string stl =
      "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid x\n";
  EXPECT_EQ(read_surface(write("a.stl", stl)).vertex_count(), 3u);
}

TEST_F(Surfaces, OtherSpellingsOfText) {
  const std::string obj =
      "\xef\xbb\xbfv 0 0 0\nv +1.5 0 0 # second\nv 0 \\\n 1 0\n# C:\\\nf 1 2 \\\r\n\\\n+3 # face\n";
  EXPECT_EQ(read_surface(write("a.obj", obj)).vertices,
            (std::vector<float>{0, 0, 0, 1.5f, 0, 0, 0, 1, 0}));
  EXPECT_EQ(read_surface(scratch_ / "a.obj").triangles, (std::vector<std::uint32_t>{0, 1, 2}));
  expect_bad(write("a.obj", "v 0 0 \\\n 0\nv 0 0 +-1\n"), "line 3");
  const std::string ply =
      "\xef\xbb\xbfply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n+1.5 0 0\n0 1 0\n3 0 1 +2\n";
  EXPECT_EQ(read_surface(write("a.ply", ply)).vertices,
            (std::vector<float>{0, 0, 0, 1.5f, 0, 0, 0, 1, 0}));
}

TEST_F(Surfaces, PlyWithoutCoordinatesOrFaces) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const char* axis : {"x", "y", "z"}) {
    std::string bytes = ply;
    bytes.replace(bytes.find(std::string("float ") + axis) + 6, 1, "u");
    expect_bad(write("a.ply", bytes), std::string("no ") + axis);
  }
  std::string strips = ply;
  strips.replace(strips.find("face"), 4, "tristrips");
  expect_bad(write("a.ply", strips), "strips");
}

TEST_F(Surfaces, BadFiles) {
  expect_bad(scratch_ / "absent.ply", "no such file");
  expect_bad(write("a.txt", "hello"), "unknown format of a surface");
  for (const char* name : {"a.vtp", "a.stl", "a.ply", "a.obj", "a.vtk"}) {
    SCOPED_TRACE(name);
    expect_bad(write(name, ""), "empty file");
    EXPECT_THROW(read_surface(write(name, "neither fish nor fowl\n")), Error);
  }
  write_surface(scratch_ / "a.obj", {{0, 0, 0}, {}}, Space::lps);
  expect_bad(scratch_ / "a.obj", "no triangles");
  expect_bad(write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), "index is out of range");
  expect_bad(write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"), "line 4");
  expect_bad(write("a.obj", "v 0 0 zero\n"), "line 1");
}

TEST_F(Surfaces, IndicesOutOfRange) {
  TriangleMesh mesh = tetrahedron();
  for (const std::uint32_t index : {4u, 1'000'000'000u, 0x7fffffffu, 0xffffffffu}) {
    mesh.triangles[4] = index;
    for (const char* name : {"a.vtp", "a.ply", "a.obj"}) {
      SCOPED_TRACE(name);
      write_surface(scratch_ / name, mesh, Space::lps);
      EXPECT_THROW(read_surface(scratch_ / name), Error);
    }
  }
  mesh.triangles[4] = 4;
  write_surface(scratch_ / "a.ply", mesh, Space::lps);
  expect_bad(scratch_ / "a.ply", "index is out of range");
}

TEST_F(Surfaces, CoordinatesThatAreNotFinite) {
  for (const float value : {std::nanf(""), INFINITY}) {
    TriangleMesh mesh = tetrahedron();
    mesh.vertices[7] = value;
    for (const char* name : kFormats) {
      SCOPED_TRACE(name);
      write_surface(scratch_ / name, mesh, Space::lps);
      expect_bad(scratch_ / name, "not finite");
    }
  }
}

/// As programs write them that count in double.
TEST_F(Surfaces, CoordinatesTooSmallForAFloatAreNearlyZero) {
  const std::string path = write("a.obj", "v 1e-46 0 0\nv 1 -2.5e-300 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(read_surface(path).vertices, (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}));
}

TEST_F(Surfaces, TruncatedFiles) {
  const TriangleMesh mesh = random_mesh(300);
  for (const char* name : {"a.vtp", "a.stl", "a.ply"}) {
    SCOPED_TRACE(name);
    write_surface(scratch_ / name, mesh, Space::lps);
    const std::string whole = read_text(scratch_ / name);
    expect_bad(write(name, whole.substr(0, whole.size() / 2)), "truncated");
  }
}

}  // namespace
}  // namespace vasamesh

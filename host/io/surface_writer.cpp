/// \file
/// Surfaces to bytes. VTK writes .vtp; STL and PLY are flat records, written here ten times as fast
/// as through VTK; VTK's OBJ has neither comments nor the digits that float32 needs.

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "io/atomic_file.h"
#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/surface_io.h"
#include "vtk_mesh.h"

namespace vasamesh {
namespace {

static_assert(std::endian::native == std::endian::little, "STL and PLY are written as they lie");

std::string surface_ending(const std::string& path) {
  const std::string ending = file_ending(path, {".vtp", ".stl", ".ply", ".obj"});
  if (!ending.empty()) return ending;
  throw Error(ErrorCode::usage,
              path + ": unknown ending of a surface; use .vtp, .stl, .ply or .obj");
}

std::array<float, 3> corner(const TriangleMesh& mesh, std::size_t triangle, int i) {
  const float* vertex = &mesh.vertices[3 * std::size_t{mesh.triangles[3 * triangle + i]}];
  return {vertex[0], vertex[1], vertex[2]};
}

std::array<float, 3> unit_normal(const std::array<float, 3>& a, const std::array<float, 3>& b,
                                 const std::array<float, 3>& c) {
  const double u[3] = {double{b[0]} - a[0], double{b[1]} - a[1], double{b[2]} - a[2]};
  const double v[3] = {double{c[0]} - a[0], double{c[1]} - a[1], double{c[2]} - a[2]};
  const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                       u[0] * v[1] - u[1] * v[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0)) return {0, 0, 0};
  return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length),
          static_cast<float>(n[2] / length)};
}

template <class T>
char* put(char* at, const T& value) {
  std::memcpy(at, &value, sizeof(T));
  return at + sizeof(T);
}

// 80 bytes of text that must not begin with "solid", the number of triangles, then for each its
// normal, three corners and two bytes of nothing.
std::string encode_stl(const TriangleMesh& mesh, Space space) {
  constexpr std::size_t kHeader = 80, kRecord = 50;
  std::string bytes(kHeader + 4 + kRecord * mesh.triangle_count(), '\0');
  const std::string text = "vasamesh SPACE=" + upper_space_name(space);
  text.copy(bytes.data(), kHeader);
  char* at = put(bytes.data() + kHeader, static_cast<std::uint32_t>(mesh.triangle_count()));
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto a = corner(mesh, t, 0), b = corner(mesh, t, 1), c = corner(mesh, t, 2);
    at = put(put(put(put(at, unit_normal(a, b, c)), a), b), c) + 2;
  }
  return bytes;
}

std::string encode_ply(const TriangleMesh& mesh, Space space) {
  const bool wide = mesh.vertex_count() > std::numeric_limits<std::int32_t>::max();
  const std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment vasamesh\ncomment SPACE={}\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar {} vertex_indices\nend_header\n",
      upper_space_name(space), mesh.vertex_count(), mesh.triangle_count(), wide ? "uint" : "int");
  const std::size_t vertex_bytes = mesh.vertices.size() * sizeof(float);
  std::string bytes(header.size() + vertex_bytes + 13 * mesh.triangle_count(), '\0');
  header.copy(bytes.data(), header.size());
  char* at = bytes.data() + header.size();
  if (vertex_bytes > 0) std::memcpy(at, mesh.vertices.data(), vertex_bytes);
  at += vertex_bytes;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    *at++ = 3;
    std::memcpy(at, &mesh.triangles[3 * t], 12);
    at += 12;
  }
  return bytes;
}

// The shortest decimals that read back as the same float32.
std::string encode_obj(const TriangleMesh& mesh, Space space) {
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text), "# vasamesh\n# SPACE={}\n", upper_space_name(space));
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    fmt::format_to(std::back_inserter(text), "v {} {} {}\n", mesh.vertices[3 * v],
                   mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]);
  }
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    fmt::format_to(
        std::back_inserter(text), "f {} {} {}\n", std::uint64_t{mesh.triangles[3 * t]} + 1,
        std::uint64_t{mesh.triangles[3 * t + 1]} + 1, std::uint64_t{mesh.triangles[3 * t + 2]} + 1);
  }
  return fmt::to_string(text);
}

vtkSmartPointer<vtkPolyData> poly_data(const TriangleMesh& mesh, Space space) {
  vtkNew<vtkStringArray> space_array;
  space_array->SetName("SPACE");
  space_array->InsertNextValue(upper_space_name(space));
  vtkSmartPointer<vtkPolyData> data = to_vtk(mesh.vertices, mesh.triangles);
  data->GetFieldData()->AddArray(space_array);
  return data;
}

void add_arrays(const std::vector<SurfaceArray>& arrays, vtkFieldData& data) {
  for (const SurfaceArray& array : arrays) {
    vtkNew<vtkFloatArray> values;
    values->SetName(array.name.c_str());
    values->SetNumberOfValues(static_cast<vtkIdType>(array.values.size()));
    std::copy(array.values.begin(), array.values.end(), values->GetPointer(0));
    data.AddArray(values);
  }
}

std::string encode_poly_data(vtkPolyData* data) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->SetHeaderTypeToUInt64();
  writer->WriteToOutputStringOn();
  if (writer->Write() != 1) throw Error(ErrorCode::internal, "VTK could not encode the surface");
  return writer->GetOutputString();
}

std::string encode_vtp(const TriangleMesh& mesh, Space space) {
  return encode_poly_data(poly_data(mesh, space));
}

}  // namespace

const char* space_name(Space space) {
  switch (space) {
    case Space::lps:
      return "lps";
    case Space::ras:
      return "ras";
    case Space::voxel:
      return "voxel";
  }
  return "";
}

std::string upper_space_name(Space space) {
  std::string name = space_name(space);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return name;
}

void check_output_path(const std::string& path) {
  surface_ending(path);
  check_writable(path);
}

void write_surface(const std::string& path, const TriangleMesh& mesh, Space space,
                   const std::atomic<bool>* cancel) {
  const std::string ending = surface_ending(path);
  const auto encode = ending == ".vtp"   ? encode_vtp
                      : ending == ".stl" ? encode_stl
                      : ending == ".ply" ? encode_ply
                                         : encode_obj;
  write_file(path, encode(mesh, space), cancel);
}

void write_surface_map(const std::string& path, const TriangleMesh& mesh, Space space,
                       const std::vector<SurfaceArray>& of_vertices,
                       const std::vector<SurfaceArray>& of_triangles,
                       const std::atomic<bool>* cancel) {
  if (surface_ending(path) != ".vtp")
    throw Error(ErrorCode::usage, path + ": a surface with numbers on it; use the ending .vtp");
  const vtkSmartPointer<vtkPolyData> data = poly_data(mesh, space);
  add_arrays(of_vertices, *data->GetPointData());
  add_arrays(of_triangles, *data->GetCellData());
  write_file(path, encode_poly_data(data), cancel);
}

}  // namespace vasamesh

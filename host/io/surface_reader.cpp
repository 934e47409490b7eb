#include <vtkFieldData.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPolyDataReader.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "io/byte_stream.h"
#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/obj_reader.h"
#include "io/ply_reader.h"
#include "io/polygons.h"
#include "io/quiet.h"
#include "io/stl_reader.h"
#include "io/surface_io.h"
#include "io/trial.h"
#include "lower_case.h"
#include "vtk_mesh.h"

namespace vasamesh {
namespace {

/// Takes VTK's messages for its lifetime and remembers whether one was an error.
class VtkMessages {
 public:
  VtkMessages() : previous_(vtkOutputWindow::GetInstance()) {
    vtkOutputWindow::SetInstance(window_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  }
  ~VtkMessages() {
    vtkLogger::SetStderrVerbosity(verbosity_);
    vtkOutputWindow::SetInstance(previous_);
  }
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;
  bool failed() const { return window_->failed; }

 private:
  class Window : public vtkOutputWindow {
   public:
    static Window* New() { VTK_STANDARD_NEW_BODY(Window); }
    void DisplayText(const char*) override {}
    void DisplayErrorText(const char*) override { failed = true; }
    void DisplayWarningText(const char*) override {}
    void DisplayGenericWarningText(const char*) override {}
    void DisplayDebugText(const char*) override {}
    bool failed = false;
  };
  vtkNew<Window> window_;
  vtkSmartPointer<vtkOutputWindow> previous_;
  vtkLogger::Verbosity verbosity_ = vtkLogger::GetCurrentVerbosityCutoff();
};

/// Runs a reader of VTK's; null when it fails.
template <class Reader>
vtkSmartPointer<vtkPolyData> run_reader(const std::string& path) {
  VtkMessages messages;
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  return messages.failed() || reader->GetErrorCode() != 0 ? nullptr : reader->GetOutput();
}

/// VTK trusts numbers in its files: it is let read on trial first.
template <class Reader>
vtkSmartPointer<vtkPolyData> try_reader(const std::string& path) {
  vtkSmartPointer<vtkPolyData> data;
  if (survives(reading_memory(file_size(path)), [&] { run_reader<Reader>(path); }))
    data = run_reader<Reader>(path);
  if (!data) {
    throw_bad_input(path, "it cannot be read as a surface: truncated, corrupt or another format",
                    "write the surface again");
  }
  return data;
}

vtkSmartPointer<vtkPolyData> read_poly_data(const std::string& path, const std::string& ending) {
  if (ending == ".vtp") return try_reader<vtkXMLPolyDataReader>(path);
  return try_reader<vtkPolyDataReader>(path);
}

void check_count(const std::string& path, vtkPolyData& data) {
  if (data.GetNumberOfPoints() > std::numeric_limits<std::uint32_t>::max()) {
    throw_bad_input(path, "it has more than 2^32 - 1 vertices", "cut the surface");
  }
}

std::uint32_t corner_of(const std::string& path, vtkIdType corner) {
  if (corner < 0 || corner > std::numeric_limits<std::uint32_t>::max()) {
    throw_bad_input(path, "a triangle's index is out of range", "write the surface again");
  }
  return static_cast<std::uint32_t>(corner);
}

void append_polygons(const std::string& path, vtkCellArray& polygons, FannedMesh& surface) {
  std::vector<std::uint32_t> corners;
  visit_cells(polygons, [&](std::span<const vtkIdType> polygon) {
    corners.clear();
    for (const vtkIdType corner : polygon) corners.push_back(corner_of(path, corner));
    surface.append(corners);
  });
}

void append_strips(const std::string& path, vtkCellArray& strips, FannedMesh& surface) {
  visit_cells(strips, [&](std::span<const vtkIdType> corners) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
      const std::size_t odd = i % 2;
      surface.append(std::array{corner_of(path, corners[i - 2]),
                                corner_of(path, corners[i - 1 + odd]),
                                corner_of(path, corners[i - odd])});
    }
  });
}

std::uint64_t hash_vertex(const float* vertex) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float value = vertex[axis] + 0.0f;  // -0 becomes 0
    hash = (hash ^ std::bit_cast<std::uint32_t>(value)) * 0x9e3779b97f4a7c15u;
  }
  return hash ^ (hash >> 32);
}

/// Merges equal vertices, 0 and -0 alike, in order of first appearance. Open addressing, half full
/// at most.
void merge_vertices(TriangleMesh& mesh) {
  constexpr std::uint32_t kEmpty = std::numeric_limits<std::uint32_t>::max();
  std::size_t slots = 16;
  while (slots < 2 * mesh.vertex_count()) slots *= 2;
  std::vector<std::uint32_t> table(slots, kEmpty), merged(mesh.vertex_count());
  std::vector<float> vertices;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const float* vertex = &mesh.vertices[3 * v];
    std::size_t slot = hash_vertex(vertex) & (slots - 1);
    while (table[slot] != kEmpty &&
           !std::equal(vertex, vertex + 3, &vertices[3 * std::size_t{table[slot]}])) {
      slot = (slot + 1) & (slots - 1);
    }
    if (table[slot] == kEmpty) {
      table[slot] = static_cast<std::uint32_t>(vertices.size() / 3);
      vertices.insert(vertices.end(), vertex, vertex + 3);
    }
    merged[v] = table[slot];
  }
  mesh.vertices = std::move(vertices);
  for (std::uint32_t& corner : mesh.triangles) corner = merged[corner];
}

/// "SPACE=LPS" and the like within `text`; none where it says nothing that is known.
std::optional<Space> named_space(std::string_view text) {
  constexpr std::string_view kKey = "SPACE=";
  const std::size_t at = text.find(kKey);
  if (at == std::string_view::npos) return std::nullopt;
  text.remove_prefix(at + kKey.size());
  for (const Space space : {Space::lps, Space::ras, Space::voxel})
    if (lower_case(std::string(text)).starts_with(space_name(space))) return space;
  return std::nullopt;
}

/// Of STL, PLY, OBJ and legacy VTK: in a comment or title at the file's head, as in 3D Slicer's.
std::optional<Space> space_in_head(const std::string& path) {
  std::array<char, 512> head{};
  const std::size_t bytes = ByteStream(path, 0, Encoding::raw).read(head.data(), head.size());
  return named_space({head.data(), bytes});
}

std::optional<Space> space_in_fields(vtkPolyData& data) {
  auto* array = vtkStringArray::SafeDownCast(data.GetFieldData()->GetAbstractArray("SPACE"));
  if (!array || array->GetNumberOfValues() != 1) return std::nullopt;
  return named_space("SPACE=" + array->GetValue(0));
}

void check_mesh(const std::string& path, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) {
    throw_bad_input(path, "it holds no triangles", "give a triangle surface");
  }
  const std::size_t count = mesh.vertex_count();
  if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(),
                  [=](std::uint32_t corner) { return corner >= count; })) {
    throw_bad_input(path, "a triangle's index is out of range", "write the surface again");
  }
  if (!std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                   [](float value) { return std::isfinite(value); })) {
    throw_bad_input(path, "a coordinate is not finite", "write the surface again");
  }
}

}  // namespace

PlacedSurface read_placed_surface(const std::string& path) {
  const Quiet quiet;
  file_size(path);
  const std::string ending = file_ending(path, {".vtp", ".stl", ".ply", ".obj", ".vtk"});
  if (ending.empty()) {
    throw_bad_input(path, "unknown format of a surface", "give .vtp, .stl, .ply, .obj or .vtk");
  }
  PlacedSurface placed;
  FannedMesh surface;
  if (ending != ".vtp") placed.space = space_in_head(path);
  if (ending == ".stl") {
    surface.mesh = read_stl(path);
  } else if (ending == ".obj") {
    surface = read_obj(path);
  } else if (ending == ".ply") {
    surface = read_ply(path);
  } else {
    const vtkSmartPointer<vtkPolyData> data = read_poly_data(path, ending);
    check_count(path, *data);
    surface.mesh.vertices = vertices_of(*data);
    append_polygons(path, *data->GetPolys(), surface);
    append_strips(path, *data->GetStrips(), surface);
    if (ending == ".vtp") placed.space = space_in_fields(*data);
  }
  check_mesh(path, surface.mesh);
  cut_polygons(surface);
  placed.mesh = std::move(surface.mesh);
  if (ending == ".stl") merge_vertices(placed.mesh);
  return placed;
}

TriangleMesh read_surface(const std::string& path) { return read_placed_surface(path).mesh; }

}  // namespace vasamesh

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkFieldData.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkSTLReader.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "io/byte_stream.h"
#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/obj_reader.h"
#include "io/ply_reader.h"
#include "io/quiet.h"
#include "io/surface_io.h"
#include "io/trial.h"
#include "lower_case.h"

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
template <class Reader, class Prepare>
vtkSmartPointer<vtkPolyData> run_reader(const std::string& path, const Prepare& prepare) {
  VtkMessages messages;
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  prepare(*reader);
  reader->Update();
  return messages.failed() || reader->GetErrorCode() != 0 ? nullptr : reader->GetOutput();
}

/// VTK trusts numbers in its files: it is let read on trial first.
template <class Reader, class Prepare>
vtkSmartPointer<vtkPolyData> try_reader(const std::string& path, const Prepare& prepare) {
  vtkSmartPointer<vtkPolyData> data;
  if (survives(reading_memory(file_size(path)), [&] { run_reader<Reader>(path, prepare); }))
    data = run_reader<Reader>(path, prepare);
  if (!data) {
    throw_bad_input(path, "it cannot be read as a surface: truncated, corrupt or another format",
                    "write the surface again");
  }
  return data;
}

vtkSmartPointer<vtkPolyData> read_poly_data(const std::string& path, const std::string& ending) {
  const auto nothing = [](auto&) {};
  if (ending == ".vtp") return try_reader<vtkXMLPolyDataReader>(path, nothing);
  if (ending == ".vtk") return try_reader<vtkPolyDataReader>(path, nothing);
  return try_reader<vtkSTLReader>(path, [](vtkSTLReader& reader) { reader.MergingOff(); });
}

/// "solid" begins a text, and some binary files: a text has no control characters but white space.
bool is_text_stl(std::string_view head) {
  return head.starts_with("solid") && std::all_of(head.begin(), head.end(), [](unsigned char c) {
           return std::iscntrl(c) == 0 || std::isspace(c) != 0;
         });
}

// VTK reads as many triangles as it finds, whatever the number before them says.
void check_stl(const std::string& path) {
  constexpr std::size_t kHeader = 84, kRecord = 50;
  std::array<char, kHeader + kRecord> head{};
  const std::size_t bytes = ByteStream(path, 0, Encoding::raw).read(head.data(), head.size());
  std::uint32_t count = 0;
  std::memcpy(&count, head.data() + 80, sizeof(count));
  const std::size_t whole = kHeader + kRecord * count,
                    size = static_cast<std::size_t>(file_size(path));
  if (size == whole || is_text_stl({head.data(), bytes})) return;
  if (size < whole) {
    throw_bad_input(path, "truncated: it holds fewer triangles than it says",
                    "get a whole copy of the file");
  }
}

void copy_vertices(const std::string& path, vtkPolyData& data, TriangleMesh& mesh) {
  const vtkIdType count = data.GetNumberOfPoints();
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    throw_bad_input(path, "it has more than 2^32 - 1 vertices", "cut the surface");
  }
  mesh.vertices.resize(3 * static_cast<std::size_t>(count));
  for (vtkIdType i = 0; i < count; ++i) {
    std::array<double, 3> point;
    data.GetPoint(i, point.data());
    for (int axis = 0; axis < 3; ++axis) {
      mesh.vertices[3 * i + axis] = static_cast<float>(point[axis]);
    }
  }
}

void append_triangle(const std::string& path, vtkIdType a, vtkIdType b, vtkIdType c,
                     TriangleMesh& mesh) {
  for (const vtkIdType corner : {a, b, c}) {
    if (corner < 0 || corner > std::numeric_limits<std::uint32_t>::max()) {
      throw_bad_input(path, "a triangle's index is out of range", "write the surface again");
    }
    mesh.triangles.push_back(static_cast<std::uint32_t>(corner));
  }
}

void append_fans(const std::string& path, vtkCellArray& polygons, TriangleMesh& mesh) {
  vtkIdType count = 0;
  const vtkIdType* corners = nullptr;
  const auto cell = vtk::TakeSmartPointer(polygons.NewIterator());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    cell->GetCurrentCell(count, corners);
    for (vtkIdType i = 2; i < count; ++i) {
      append_triangle(path, corners[0], corners[i - 1], corners[i], mesh);
    }
  }
}

void append_strips(const std::string& path, vtkCellArray& strips, TriangleMesh& mesh) {
  vtkIdType count = 0;
  const vtkIdType* corners = nullptr;
  const auto cell = vtk::TakeSmartPointer(strips.NewIterator());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    cell->GetCurrentCell(count, corners);
    for (vtkIdType i = 2; i < count; ++i) {
      const vtkIdType odd = i % 2;
      append_triangle(path, corners[i - 2], corners[i - 1 + odd], corners[i - odd], mesh);
    }
  }
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
  PlacedSurface surface;
  TriangleMesh& mesh = surface.mesh;
  if (ending != ".vtp") surface.space = space_in_head(path);
  if (ending == ".stl") check_stl(path);
  if (ending == ".obj") {
    mesh = read_obj(path);
  } else if (ending == ".ply") {
    mesh = read_ply(path);
  } else {
    const vtkSmartPointer<vtkPolyData> data = read_poly_data(path, ending);
    copy_vertices(path, *data, mesh);
    append_fans(path, *data->GetPolys(), mesh);
    append_strips(path, *data->GetStrips(), mesh);
    if (ending == ".vtp") surface.space = space_in_fields(*data);
  }
  check_mesh(path, mesh);
  if (ending == ".stl") merge_vertices(mesh);
  return surface;
}

TriangleMesh read_surface(const std::string& path) { return read_placed_surface(path).mesh; }

}  // namespace vasamesh

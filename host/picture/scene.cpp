#include "picture/scene.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPNGWriter.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>
#include <vtkWindowToImageFilter.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "vasamesh/errors.h"

namespace vasamesh {
namespace {

constexpr double kVessel[3] = {0.76, 0.12, 0.11};
constexpr double kEdge[3] = {0.16, 0.02, 0.02};
constexpr int kSamples = 8;       ///< a pixel, against jagged outlines
constexpr double kBorder = 1.04;  ///< room round the surface

template <class Reader>
vtkSmartPointer<vtkPolyData> read_with(const std::string& path) {
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  return reader->GetOutput();
}

vtkSmartPointer<vtkPolyData> read_any(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".vtp") return read_with<vtkXMLPolyDataReader>(path);
  if (ending == ".stl") return read_with<vtkSTLReader>(path);
  if (ending == ".ply") return read_with<vtkPLYReader>(path);
  if (ending == ".obj") return read_with<vtkOBJReader>(path);
  throw Error(ErrorCode::bad_input,
              fmt::format("{}: unknown ending; give .vtp, .stl, .ply or .obj", path));
}

vtkSmartPointer<vtkPolyData> load(const std::string& path) {
  if (!std::filesystem::exists(path))
    throw Error(ErrorCode::bad_input, fmt::format("{}: no such file; check the path", path));
  auto surface = read_any(path);
  if (surface->GetNumberOfPolys() == 0)
    throw Error(ErrorCode::bad_input, fmt::format("{}: no triangles to draw", path));
  return surface;
}

vtkSmartPointer<vtkActor> make_actor(vtkPolyData* surface, bool edges) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(surface);
  normals->SplittingOff();
  normals->ConsistencyOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(normals->GetOutputPort());
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty* look = actor->GetProperty();
  look->SetColor(kVessel[0], kVessel[1], kVessel[2]);
  look->SetAmbient(0.12);
  look->SetDiffuse(0.85);
  look->SetSpecular(0.35);
  look->SetSpecularPower(35);
  look->SetInterpolationToPhong();
  look->SetEdgeColor(kEdge[0], kEdge[1], kEdge[2]);
  look->SetEdgeVisibility(edges);
  return actor.Get();
}

void add_light(vtkRenderer* renderer, double x, double y, double strength) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, 1);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(strength);
  renderer->AddLight(light);
}

/// A parallel view that the surface, or the ball to zoom to, fills.
void aim(vtkRenderer* renderer, vtkPolyData* surface, const PictureOptions& options) {
  vtkCamera* camera = renderer->GetActiveCamera();
  const auto& view = options.view;
  const double length = std::hypot(view[0], view[1], view[2]);
  const bool from_above = std::abs(view[2]) > 0.9 * length;
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(0, 0, 0);
  camera->SetPosition(view[0] / length, view[1] / length, view[2] / length);
  camera->SetViewUp(0, from_above ? 1 : 0, from_above ? 0 : 1);
  double box[6];
  surface->GetBounds(box);
  double centre[3], half[3];
  for (int a = 0; a < 3; ++a) {
    centre[a] = 0.5 * (box[2 * a] + box[2 * a + 1]);
    half[a] = 0.5 * (box[2 * a + 1] - box[2 * a]);
  }
  vtkMatrix4x4* to_eye = camera->GetViewTransformMatrix();
  double reach[2] = {0, 0};  // of the bounding box, across and up the picture
  for (int row = 0; row < 2; ++row)
    for (int a = 0; a < 3; ++a) reach[row] += std::abs(to_eye->GetElement(row, a)) * half[a];
  const double aspect = static_cast<double>(options.size[0]) / options.size[1];
  double scale = kBorder * std::max(reach[1], reach[0] / aspect);
  if (options.zoom) {
    std::copy_n(options.zoom->data(), 3, centre);
    scale = (*options.zoom)[3] / std::min(1.0, aspect);
  }
  const double away = 2 * std::hypot(half[0], half[1], half[2]) + scale;
  camera->SetFocalPoint(centre);
  camera->SetPosition(centre[0] + away * view[0] / length, centre[1] + away * view[1] / length,
                      centre[2] + away * view[2] / length);
  camera->SetParallelScale(scale);
  renderer->ResetCameraClippingRange();
}

void write_png(vtkRenderWindow* window, const std::string& path) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(image->GetOutputPort());
  writer->SetFileName(path.c_str());
  writer->Write();
  if (writer->GetErrorCode() != 0)
    throw Error(ErrorCode::refused,
                fmt::format("{}: cannot be written; check the folder and the disk", path));
}

}  // namespace

void render_picture(const PictureOptions& options) {
  const auto surface = load(options.surface);
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->AutomaticLightCreationOff();
  add_light(renderer, -0.5, 0.8, 0.85);  // key light, from above on the left
  add_light(renderer, 0.9, -0.2, 0.3);   // fill light
  renderer->AddActor(make_actor(surface, options.edges));
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(kSamples);
  window->SetSize(options.size[0], options.size[1]);
  window->AddRenderer(renderer);
  aim(renderer, surface, options);
  window->Render();
  write_png(window, options.output);
}

}  // namespace vasamesh

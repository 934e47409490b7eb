#include "picture/scene.h"

#include <fmt/format.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkImageShrink3D.h>
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

constexpr double kVessel[3] = {0.74, 0.13, 0.12};
constexpr double kEdge[3] = {0.16, 0.02, 0.02};
constexpr int kSamples = 2;       ///< a pixel along each axis, against jagged outlines
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
  look->SetAmbient(0.15);
  look->SetDiffuse(0.8);
  look->SetSpecular(0.25);
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

/// Half the extent of the surface across and up the picture, and its middle there.
struct Frame {
  double middle[2], half[2];
};

Frame frame_of(vtkPolyData* surface, vtkMatrix4x4* to_eye) {
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i) {
    double p[4] = {0, 0, 0, 1}, seen[4];
    surface->GetPoint(i, p);
    to_eye->MultiplyPoint(p, seen);
    for (int a = 0; a < 2; ++a) {
      low[a] = std::min(low[a], seen[a]);
      high[a] = std::max(high[a], seen[a]);
    }
  }
  return {{0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])},
          {0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])}};
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
  vtkMatrix4x4* to_eye = camera->GetViewTransformMatrix();
  const Frame frame = frame_of(surface, to_eye);
  const double aspect = static_cast<double>(options.size[0]) / options.size[1];
  double centre[3], scale = kBorder * std::max(frame.half[1], frame.half[0] / aspect);
  for (int a = 0; a < 3; ++a)
    centre[a] =
        frame.middle[0] * to_eye->GetElement(0, a) + frame.middle[1] * to_eye->GetElement(1, a);
  if (options.zoom) {
    std::copy_n(options.zoom->data(), 3, centre);
    scale = (*options.zoom)[3] / std::min(1.0, aspect);
  }
  camera->SetFocalPoint(centre);
  const double away = 2 * surface->GetLength() / length;  // outside, whatever is zoomed to
  camera->SetPosition(centre[0] + away * view[0], centre[1] + away * view[1],
                      centre[2] + away * view[2]);
  camera->SetParallelScale(scale);
  renderer->ResetCameraClippingRange();
}

void write_png(vtkRenderWindow* window, const std::string& path) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->ReadFrontBufferOff();
  vtkNew<vtkImageShrink3D> mean;
  mean->SetInputConnection(image->GetOutputPort());
  mean->SetShrinkFactors(kSamples, kSamples, 1);
  mean->MeanOn();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(mean->GetOutputPort());
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
  add_light(renderer, -0.5, 0.8, 0.75);  // key light, from above on the left
  add_light(renderer, 0.9, -0.2, 0.35);  // fill light
  add_light(renderer, 0, 0, 0.2);        // from the eye
  renderer->AddActor(make_actor(surface, options.edges));
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetSize(kSamples * options.size[0], kSamples * options.size[1]);
  window->AddRenderer(renderer);
  aim(renderer, surface, options);
  window->Render();
  write_png(window, options.output);
}

}  // namespace vasamesh

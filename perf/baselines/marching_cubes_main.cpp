/// \file
/// vasamesh_baseline_mc VOLUME SURFACE.ply [--smooth]: VTK's FlyingEdges3D at 0.5, the volume's
/// border closed by background. With --smooth, as viewers do: WindowedSinc (20 iterations, pass
/// band 0.1), then QuadricDecimation by half.

#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include "io/marching_cubes.h"
#include "io/surface_io.h"
#include "program.h"

namespace vasamesh::baselines {
namespace {

constexpr int kIterations = 20;
constexpr double kPassBand = 0.1, kReduction = 0.5;

vtkSmartPointer<vtkPolyData> to_vtk(const TriangleMesh& mesh) {
  vtkNew<vtkPoints> points;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += 3)
    points->InsertNextPoint(&mesh.vertices[v]);
  vtkNew<vtkCellArray> cells;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    cells->InsertNextCell({mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]});
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(cells);
  return data;
}

TriangleMesh from_vtk(vtkPolyData& data) {
  TriangleMesh mesh;
  for (vtkIdType v = 0; v < data.GetNumberOfPoints(); ++v)
    for (int a = 0; a < 3; ++a) mesh.vertices.push_back(static_cast<float>(data.GetPoint(v)[a]));
  vtkNew<vtkIdList> corners;
  for (vtkIdType t = 0; t < data.GetNumberOfCells(); ++t) {
    data.GetCellPoints(t, corners);
    for (int i = 0; i < 3; ++i)
      mesh.triangles.push_back(static_cast<std::uint32_t>(corners->GetId(i)));
  }
  return mesh;
}

TriangleMesh smoothed(const TriangleMesh& mesh) {
  vtkNew<vtkWindowedSincPolyDataFilter> smooth;
  smooth->SetInputData(to_vtk(mesh));
  smooth->SetNumberOfIterations(kIterations);
  smooth->SetPassBand(kPassBand);
  vtkNew<vtkQuadricDecimation> decimate;
  decimate->SetInputConnection(smooth->GetOutputPort());
  decimate->SetTargetReduction(kReduction);
  decimate->Update();
  return from_vtk(*decimate->GetOutput());
}

}  // namespace
}  // namespace vasamesh::baselines

int main(int argc, char** argv) {
  using namespace vasamesh;
  CLI::App app("Marching cubes", "vasamesh_baseline_mc");
  bool smooth = false;
  app.add_flag("--smooth", smooth, "WindowedSinc and QuadricDecimation after it");
  return baselines::run_program(
      app, argc, argv, [&](const Segmentation& volume, const std::string& output) {
        const TriangleMesh mesh = marching_cubes(volume);
        write_surface(output, smooth ? baselines::smoothed(mesh) : mesh, Space::lps);
      });
}

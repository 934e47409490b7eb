#include "vtk_mesh.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkTypeInt32Array.h>
#include <vtkTypeInt64Array.h>

#include <algorithm>
#include <limits>

namespace vasamesh {

namespace {

/// Offsets and corners of the triangles in arrays of the VTK type `Array`.
template <class Array>
void set_cells(std::span<const std::uint32_t> triangles, vtkCellArray& cells) {
  vtkNew<Array> offsets, corners;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(triangles.size() / 3) + 1);
  for (vtkIdType i = 0; i < offsets->GetNumberOfValues(); ++i)
    offsets->SetValue(i, static_cast<typename Array::ValueType>(3 * i));
  corners->SetNumberOfValues(static_cast<vtkIdType>(triangles.size()));
  std::copy(triangles.begin(), triangles.end(), corners->GetPointer(0));
  cells.SetData(offsets, corners);
}

template <class Array>
vtkSmartPointer<vtkPolyData> surface_of(std::span<const typename Array::ValueType> vertices,
                                        std::span<const std::uint32_t> triangles) {
  vtkNew<Array> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(static_cast<vtkIdType>(vertices.size() / 3));
  std::copy(vertices.begin(), vertices.end(), coordinates->GetPointer(0));
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  vtkNew<vtkCellArray> cells;
  const bool wide = triangles.size() > std::numeric_limits<std::int32_t>::max();
  if (wide)
    set_cells<vtkTypeInt64Array>(triangles, *cells);
  else
    set_cells<vtkTypeInt32Array>(triangles, *cells);
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(points);
  surface->SetPolys(cells);
  return surface;
}

}  // namespace

std::vector<float> vertices_of(vtkPolyData& surface,
                               const std::function<VtkPoint(const VtkPoint&)>& place) {
  std::vector<float> vertices;
  vertices.reserve(3 * static_cast<std::size_t>(surface.GetNumberOfPoints()));
  for (vtkIdType i = 0; i < surface.GetNumberOfPoints(); ++i) {
    VtkPoint point;
    surface.GetPoint(i, point.data());
    if (place) point = place(point);
    for (const double x : point) vertices.push_back(static_cast<float>(x));
  }
  return vertices;
}

std::vector<std::uint32_t> triangles_of(vtkPolyData& surface) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(3 * static_cast<std::size_t>(surface.GetNumberOfPolys()));
  visit_cells(*surface.GetPolys(), [&](std::span<const vtkIdType> corners) {
    for (const vtkIdType corner : corners) triangles.push_back(static_cast<std::uint32_t>(corner));
  });
  return triangles;
}

vtkSmartPointer<vtkPolyData> to_vtk(std::span<const float> vertices,
                                    std::span<const std::uint32_t> triangles) {
  return surface_of<vtkFloatArray>(vertices, triangles);
}

vtkSmartPointer<vtkPolyData> to_vtk(std::span<const double> vertices,
                                    std::span<const std::uint32_t> triangles) {
  return surface_of<vtkDoubleArray>(vertices, triangles);
}

}  // namespace vasamesh

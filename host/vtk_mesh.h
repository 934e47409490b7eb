#pragma once

/// \file
/// Surfaces out of VTK's data and into them.

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace vasamesh {

using VtkPoint = std::array<double, 3>;

/// The points rounded to float32, each moved by `place` before, where there is one.
std::vector<float> vertices_of(vtkPolyData& surface,
                               const std::function<VtkPoint(const VtkPoint&)>& place = {});

/// \pre all polygons are triangles, of fewer than 2^32 points.
std::vector<std::uint32_t> triangles_of(vtkPolyData& surface);

/// A surface of three coordinates a vertex, kept as they are, and three corners a triangle.
vtkSmartPointer<vtkPolyData> to_vtk(std::span<const float> vertices,
                                    std::span<const std::uint32_t> triangles);
vtkSmartPointer<vtkPolyData> to_vtk(std::span<const double> vertices,
                                    std::span<const std::uint32_t> triangles);

/// visit(std::span<const vtkIdType>) for the points of each cell, in order.
template <class Visit>
void visit_cells(vtkCellArray& cells, const Visit& visit) {
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  const auto cell = vtk::TakeSmartPointer(cells.NewIterator());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    cell->GetCurrentCell(count, ids);
    visit(std::span(ids, static_cast<std::size_t>(count)));
  }
}

}  // namespace vasamesh

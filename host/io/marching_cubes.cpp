#include "io/marching_cubes.h"

#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>

#include <algorithm>
#include <array>
#include <utility>

#include "vasamesh/errors.h"
#include "vtk_mesh.h"

namespace vasamesh {
namespace {

using Index = std::array<std::int64_t, 3>;

/// Voxels first .. last, one more than the object on every side; may lie outside the volume.
struct Extent {
  Index first, last;
};

Extent object_extent(const Segmentation& segmentation) {
  const Index& size = segmentation.geometry.size;
  Extent extent{size, {-1, -1, -1}};
  std::size_t i = 0;
  for (std::int64_t z = 0; z < size[2]; ++z)
    for (std::int64_t y = 0; y < size[1]; ++y, i += size[0]) {
      const auto row = segmentation.voxels.begin() + i, end = row + size[0];
      const auto first = std::find_if(row, end, [](std::uint8_t v) { return v != 0; });
      if (first == end) continue;
      auto last = end - 1;
      while (*last == 0) --last;
      const Index low{first - row, y, z}, high{last - row, y, z};
      for (int a = 0; a < 3; ++a) {
        extent.first[a] = std::min(extent.first[a], low[a] - 1);
        extent.last[a] = std::max(extent.last[a], high[a] + 1);
      }
    }
  if (extent.last[0] < 0)
    throw Error(ErrorCode::bad_input,
                "nothing is in the foreground of the volume: there is no surface to compare with");
  return extent;
}

/// The extent's voxels as 0 and 1, at their indices relative to its first.
vtkSmartPointer<vtkImageData> make_image(const Segmentation& segmentation, const Extent& extent) {
  const Index& size = segmentation.geometry.size;
  const auto image = vtkSmartPointer<vtkImageData>::New();
  Index count;
  for (int a = 0; a < 3; ++a) count[a] = extent.last[a] - extent.first[a] + 1;
  image->SetDimensions(static_cast<int>(count[0]), static_cast<int>(count[1]),
                       static_cast<int>(count[2]));
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  auto* to = static_cast<std::uint8_t*>(image->GetScalarPointer());
  for (std::int64_t z = extent.first[2]; z <= extent.last[2]; ++z)
    for (std::int64_t y = extent.first[1]; y <= extent.last[1]; ++y)
      for (std::int64_t x = extent.first[0]; x <= extent.last[0]; ++x) {
        const bool within = x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
        *to++ = within && segmentation.voxels[x + size[0] * (y + size[1] * z)] != 0;
      }
  return image;
}

std::array<double, 3> to_lps(const Geometry& geometry, const std::array<double, 3>& voxel) {
  std::array<double, 3> p = geometry.origin;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      p[a] += geometry.direction[3 * a + b] * (geometry.spacing[b] * voxel[b]);
  return p;
}

bool mirrored(const std::array<double, 9>& d) {
  return d[0] * (d[4] * d[8] - d[5] * d[7]) - d[1] * (d[3] * d[8] - d[5] * d[6]) +
             d[2] * (d[3] * d[7] - d[4] * d[6]) <
         0;
}

/// Turns every triangle round.
void turn(std::vector<std::uint32_t>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); i += 3)
    std::swap(triangles[i + 1], triangles[i + 2]);
}

}  // namespace

TriangleMesh marching_cubes(const Segmentation& segmentation) {
  const Extent extent = object_extent(segmentation);
  const vtkSmartPointer<vtkImageData> image = make_image(segmentation, extent);
  vtkNew<vtkFlyingEdges3D> filter;
  filter->SetInputData(image);
  filter->SetValue(0, 0.5);
  filter->ComputeNormalsOff();
  filter->ComputeScalarsOff();
  filter->Update();
  const auto place = [&](VtkPoint voxel) {
    for (std::size_t a = 0; a < 3; ++a) voxel[a] += static_cast<double>(extent.first[a]);
    return to_lps(segmentation.geometry, voxel);
  };
  vtkPolyData& surface = *filter->GetOutput();
  TriangleMesh mesh{vertices_of(surface, place), triangles_of(surface)};
  if (mirrored(segmentation.geometry.direction)) turn(mesh.triangles);
  return mesh;
}

}  // namespace vasamesh

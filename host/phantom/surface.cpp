#include "phantom/surface.h"

#include <tbb/parallel_for.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkClipClosedSurface.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPlaneCollection.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "phantom/lattice.h"
#include "tbb/task_order.h"

namespace vasamesh {
namespace {

constexpr int kBlockCells = 12;
constexpr int kNewtonSteps = 4;

/// Triangles in lattice units, with doubled vertices where blocks meet.
struct Patch {
  std::vector<std::array<float, 3>> points;
  std::vector<std::uint32_t> triangles;
};

/// Whether a block holds only the lattice's last nodes along an axis: no cells.
bool is_rim(const Block& block, const VoxelGrid& lattice) {
  for (int a = 0; a < 3; ++a)
    if (block.low[a] == lattice.size[a] - 1) return true;
  return false;
}

vtkSmartPointer<vtkImageData> sample_block(const Block& block, const VoxelGrid& lattice) {
  Index3 high;
  for (int a = 0; a < 3; ++a) high[a] = std::min(block.high[a], lattice.size[a] - 1);
  vtkNew<vtkImageData> image;
  image->SetExtent(block.low[0], high[0], block.low[1], high[1], block.low[2], high[2]);
  image->AllocateScalars(VTK_FLOAT, 1);
  auto* values = static_cast<float*>(image->GetScalarPointer());
  const double far = 8 * lattice.step[0];
  for (int k = block.low[2]; k <= high[2]; ++k)
    for (int j = block.low[1]; j <= high[1]; ++j)
      for (int i = block.low[0]; i <= high[0]; ++i) {
        const double distance = block.solid.distance(lattice.node(i, j, k));
        // Never zero, and turned round: Flying Edges makes the larger values the inside.
        const auto value = static_cast<float>(std::clamp(-distance, -far, far));
        *values++ = value == 0 ? 1e-12f : value;
      }
  return image.Get();
}

Patch contour_block(const Block& block, const VoxelGrid& lattice) {
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(sample_block(block, lattice));
  contour->SetValue(0, 0.0);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  vtkPolyData* surface = contour->GetOutput();
  Patch patch;
  patch.points.resize(surface->GetNumberOfPoints());
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i) {
    double p[3];
    surface->GetPoint(i, p);
    for (int a = 0; a < 3; ++a) patch.points[i][a] = static_cast<float>(p[a]);
  }
  auto cell = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    vtkIdType count;
    const vtkIdType* ids;
    cell->GetCurrentCell(count, ids);
    for (int c = 0; c < 3; ++c) patch.triangles.push_back(static_cast<std::uint32_t>(ids[c]));
  }
  return patch;
}

/// Newton's method along the gradient: onto the zero set.
Vec3 project(const Shape& solid, Vec3 p, double step) {
  const double eps = 1e-4 * step;
  for (int n = 0; n < kNewtonSteps; ++n) {
    const double distance = solid.distance(p);
    Vec3 gradient;
    for (int a = 0; a < 3; ++a) {
      const Vec3 e = eps * Vec3::Unit(a);
      gradient[a] = (solid.distance(p + e) - solid.distance(p - e)) / (2 * eps);
    }
    const double square = gradient.squaredNorm();
    if (square < 0.25 || std::abs(distance) < 1e-6 * step) break;
    p -= gradient * (distance / square);
  }
  return p;
}

struct PointHash {
  std::size_t operator()(const std::array<float, 3>& p) const {
    std::uint64_t hash = 0;
    for (float v : p) hash = (hash ^ std::bit_cast<std::uint32_t>(v)) * 0x9e3779b97f4a7c15ull;
    return static_cast<std::size_t>(hash ^ (hash >> 29));
  }
};

/// A mesh in double precision, with the block that each vertex came from.
struct Joined {
  std::vector<std::array<float, 3>> points;  ///< lattice units
  std::vector<std::size_t> block;
  std::vector<std::uint32_t> triangles;
};

Joined join(const std::vector<Patch>& patches) {
  Joined joined;
  std::unordered_map<std::array<float, 3>, std::uint32_t, PointHash> ids;
  for (std::size_t b = 0; b < patches.size(); ++b)
    for (std::uint32_t corner : patches[b].triangles) {
      const auto& point = patches[b].points[corner];
      const auto id = static_cast<std::uint32_t>(joined.points.size());
      const auto [entry, is_new] = ids.try_emplace(point, id);
      if (is_new) joined.points.push_back(point), joined.block.push_back(b);
      joined.triangles.push_back(entry->second);
    }
  return joined;
}

std::vector<Vec3> projected_points(const Joined& joined, const std::vector<Block>& blocks,
                                   const VoxelGrid& lattice) {
  std::vector<Vec3> points(joined.points.size());
  const auto project_point = [&](std::size_t i) {
    const auto& p = joined.points[i];
    const Vec3 place = lattice.start + Vec3(p[0], p[1], p[2]).cwiseProduct(lattice.step);
    points[i] = project(blocks[joined.block[i]].solid, place, lattice.step[0]);
  };
  tbb::parallel_for(std::size_t{0}, points.size(), TaskOrder().around(project_point));
  return points;
}

vtkSmartPointer<vtkPolyData> to_vtk(const std::vector<Vec3>& points,
                                    const std::vector<std::uint32_t>& triangles) {
  vtkNew<vtkPoints> vertices;
  vertices->SetDataTypeToDouble();
  for (const Vec3& p : points) vertices->InsertNextPoint(p.data());
  vtkNew<vtkCellArray> cells;
  for (std::size_t t = 0; t < triangles.size(); t += 3)
    cells->InsertNextCell({triangles[t], triangles[t + 1], triangles[t + 2]});
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(vertices);
  surface->SetPolys(cells);
  return surface.Get();
}

/// Cuts the surface by the box and closes the cuts.
vtkSmartPointer<vtkPolyData> clip(vtkPolyData* surface, const Eigen::AlignedBox3d& border) {
  vtkNew<vtkPlaneCollection> planes;
  for (int a = 0; a < 3; ++a)
    for (int side = 0; side < 2; ++side) {
      vtkNew<vtkPlane> plane;
      Vec3 normal = side ? Vec3(-Vec3::Unit(a)) : Vec3(Vec3::Unit(a));
      Vec3 origin = side ? border.max() : border.min();
      plane->SetNormal(normal.data());
      plane->SetOrigin(origin.data());
      planes->AddItem(plane);
    }
  vtkNew<vtkClipClosedSurface> cut;
  cut->SetInputData(surface);
  cut->SetClippingPlanes(planes);
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputConnection(cut->GetOutputPort());
  triangles->PassLinesOff();
  triangles->PassVertsOff();
  triangles->Update();
  vtkNew<vtkPolyData> result;
  result->ShallowCopy(triangles->GetOutput());
  return result.Get();
}

TriangleMesh to_mesh(vtkPolyData* surface, const Vec3& shift) {
  TriangleMesh mesh;
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i) {
    double p[3];
    surface->GetPoint(i, p);
    for (int a = 0; a < 3; ++a) mesh.vertices.push_back(static_cast<float>(p[a] + shift[a]));
  }
  auto cell = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    vtkIdType count;
    const vtkIdType* ids;
    cell->GetCurrentCell(count, ids);
    for (int c = 0; c < 3; ++c) mesh.triangles.push_back(static_cast<std::uint32_t>(ids[c]));
  }
  return mesh;
}

VoxelGrid sampling_lattice(const Eigen::AlignedBox3d& bounds, double step) {
  VoxelGrid lattice;
  lattice.start = bounds.min() - Vec3::Constant(2.5 * step);
  lattice.step = Vec3::Constant(step);
  for (int a = 0; a < 3; ++a)
    lattice.size[a] = 6 + static_cast<int>(std::ceil(bounds.sizes()[a] / step));
  return lattice;
}

}  // namespace

TriangleMesh exact_surface(const Shape& solid, const Eigen::AlignedBox3d& border, double step,
                           const Vec3& shift) {
  const Eigen::AlignedBox3d bounds = solid.bounds();
  const bool cut = !border.contains(bounds);
  const VoxelGrid lattice = sampling_lattice(cut ? bounds.intersection(border) : bounds, step);
  std::vector<Block> blocks = find_blocks(solid, lattice, kBlockCells, 4 * step);
  std::erase_if(blocks, [&](const Block& block) { return block.inside || is_rim(block, lattice); });
  std::vector<Patch> patches(blocks.size());
  const auto contour = [&](std::size_t b) { patches[b] = contour_block(blocks[b], lattice); };
  tbb::parallel_for(std::size_t{0}, blocks.size(), TaskOrder().around(contour));
  const Joined joined = join(patches);
  const std::vector<Vec3> points = projected_points(joined, blocks, lattice);
  const vtkSmartPointer<vtkPolyData> surface = to_vtk(points, joined.triangles);
  return to_mesh(cut ? clip(surface, border) : surface, shift);
}

}  // namespace vasamesh

#include "phantom/surface.h"

#include <tbb/parallel_for.h>
#include <vtkClipClosedSurface.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPlaneCollection.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "phantom/lattice.h"
#include "tbb/task_order.h"
#include "vtk_mesh.h"

namespace vasamesh {
namespace {

constexpr int kBlockCells = 12;
constexpr int kNewtonSteps = 4;

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

/// Triangles in lattice units, with doubled vertices where blocks meet.
TriangleMesh contour_block(const Block& block, const VoxelGrid& lattice) {
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(sample_block(block, lattice));
  contour->SetValue(0, 0.0);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  vtkPolyData& surface = *contour->GetOutput();
  return {vertices_of(surface), triangles_of(surface)};
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

/// A mesh of whole patches, with the block that each vertex came from.
struct Joined {
  std::vector<std::array<float, 3>> points;  ///< lattice units
  std::vector<std::size_t> block;
  std::vector<std::uint32_t> triangles;
};

Joined join(const std::vector<TriangleMesh>& patches) {
  Joined joined;
  std::unordered_map<std::array<float, 3>, std::uint32_t, PointHash> ids;
  for (std::size_t b = 0; b < patches.size(); ++b)
    for (std::uint32_t corner : patches[b].triangles) {
      const float* v = &patches[b].vertices[3 * std::size_t{corner}];
      const std::array<float, 3> point = {v[0], v[1], v[2]};
      const auto id = static_cast<std::uint32_t>(joined.points.size());
      const auto [entry, is_new] = ids.try_emplace(point, id);
      if (is_new) joined.points.push_back(point), joined.block.push_back(b);
      joined.triangles.push_back(entry->second);
    }
  return joined;
}

/// x, y, z of each point on the zero set.
std::vector<double> projected_points(const Joined& joined, const std::vector<Block>& blocks,
                                     const VoxelGrid& lattice) {
  std::vector<double> points(3 * joined.points.size());
  const auto project_point = [&](std::size_t i) {
    const auto& p = joined.points[i];
    const Vec3 place = lattice.start + Vec3(p[0], p[1], p[2]).cwiseProduct(lattice.step);
    const Vec3 on_surface = project(blocks[joined.block[i]].solid, place, lattice.step[0]);
    std::copy_n(on_surface.data(), 3, &points[3 * i]);
  };
  tbb::parallel_for(std::size_t{0}, joined.points.size(), TaskOrder().around(project_point));
  return points;
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
  std::vector<TriangleMesh> patches(blocks.size());
  const auto contour = [&](std::size_t b) { patches[b] = contour_block(blocks[b], lattice); };
  tbb::parallel_for(std::size_t{0}, blocks.size(), TaskOrder().around(contour));
  const Joined joined = join(patches);
  vtkSmartPointer<vtkPolyData> surface =
      to_vtk(projected_points(joined, blocks, lattice), joined.triangles);
  if (cut) surface = clip(surface, border);
  const auto shifted = [&](const VtkPoint& p) {
    return VtkPoint{p[0] + shift[0], p[1] + shift[1], p[2] + shift[2]};
  };
  return {vertices_of(*surface, shifted), triangles_of(*surface)};
}

}  // namespace vasamesh

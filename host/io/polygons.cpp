#include "io/polygons.h"

#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolygon.h>

#include <algorithm>
#include <limits>

#include "types/vec3d.h"

namespace vasamesh {
namespace {

constexpr std::size_t kMostTriangles = std::size_t{1} << 14;
constexpr double kLeastShare = 1e-12;  // of the polygon's area

Vec3d corner_at(const TriangleMesh& mesh, std::uint32_t corner) {
  const float* v = &mesh.vertices[3 * std::size_t{corner}];
  return {v[0], v[1], v[2]};
}

/// Twice the area, times the normal.
Vec3d area_vector(const TriangleMesh& mesh, const std::uint32_t* triangle) {
  const Vec3d a = corner_at(mesh, triangle[0]);
  return cross(corner_at(mesh, triangle[1]) - a, corner_at(mesh, triangle[2]) - a);
}

/// The least triangle's part of the polygon's area, below zero where it faces the other way.
double least_share(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles) {
  Vec3d whole;
  for (std::size_t i = 0; i < triangles.size(); i += 3)
    whole = whole + area_vector(mesh, &triangles[i]);
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < triangles.size(); i += 3)
    least = std::min(least, dot(area_vector(mesh, &triangles[i]), whole));
  return least > 0 ? least / dot(whole, whole) : least;
}

std::vector<std::uint32_t> corners_of(std::span<const std::uint32_t> fan) {
  std::vector<std::uint32_t> corners = {fan[0], fan[1]};
  for (std::size_t i = 2; i < fan.size(); i += 3) corners.push_back(fan[i]);
  return corners;
}

/// Empty where VTK finds no more ears.
std::vector<std::uint32_t> without_ears(const TriangleMesh& mesh,
                                        const std::vector<std::uint32_t>& corners) {
  vtkNew<vtkPolygon> polygon;
  const auto count = static_cast<vtkIdType>(corners.size());
  polygon->GetPoints()->SetNumberOfPoints(count);
  polygon->GetPointIds()->SetNumberOfIds(count);
  for (vtkIdType i = 0; i < count; ++i) {
    const Vec3d p = corner_at(mesh, corners[static_cast<std::size_t>(i)]);
    polygon->GetPoints()->SetPoint(i, p.x, p.y, p.z);
    polygon->GetPointIds()->SetId(i, i);
  }
  vtkNew<vtkIdList> ears;
  std::vector<std::uint32_t> triangles;
  if (polygon->EarCutTriangulation(ears) == 0) return triangles;
  for (vtkIdType i = 0; i < ears->GetNumberOfIds(); ++i)
    triangles.push_back(corners[static_cast<std::size_t>(ears->GetId(i))]);
  return triangles;
}

void cut(const TriangleMesh& mesh, std::span<std::uint32_t> fan) {
  const double share = least_share(mesh, fan);
  if (share > kLeastShare) return;
  const std::vector<std::uint32_t> ears = without_ears(mesh, corners_of(fan));
  if (ears.size() == fan.size() && least_share(mesh, ears) > share)
    std::copy(ears.begin(), ears.end(), fan.begin());
}

}  // namespace

void FannedMesh::append(std::span<const std::uint32_t> corners) {
  if (corners.size() > 3) fans.push_back({mesh.triangle_count(), corners.size() - 2});
  for (std::size_t i = 2; i < corners.size(); ++i)
    mesh.triangles.insert(mesh.triangles.end(), {corners[0], corners[i - 1], corners[i]});
}

void cut_polygons(FannedMesh& surface) {
  for (const FannedMesh::Fan& fan : surface.fans)
    if (fan.count <= kMostTriangles)
      cut(surface.mesh, std::span(surface.mesh.triangles).subspan(3 * fan.first, 3 * fan.count));
}

}  // namespace vasamesh

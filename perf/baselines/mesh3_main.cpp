/// \file
/// vasamesh_baseline_mesh3 VOLUME SURFACE.ply [--size S] [--distance D]: CGAL's Mesh_3 on the
/// image, the boundary of its tetrahedra. Each piece of the segmentation gets its first points.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/ImageIO.h>
#include <CGAL/Image_3.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_3/initialize_triangulation_from_labeled_image.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "io/surface_io.h"
#include "program.h"

namespace vasamesh::baselines {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace parameters = CGAL::parameters;

constexpr double kLeastAngle = 30;  // degrees, of a facet; the largest that is sure to end
constexpr int kBorder = 2;

/// A copy, at the origin and along the axes.
CGAL::Image_3 to_cgal(const Segmentation& volume) {
  const auto& size = volume.geometry.size;
  const auto& spacing = volume.geometry.spacing;
  _image* image = _createImage(size[0], size[1], size[2], 1, spacing[0], spacing[1], spacing[2], 1,
                               WK_FIXED, SGN_UNSIGNED);
  std::copy(volume.voxels.begin(), volume.voxels.end(), static_cast<unsigned char*>(image->data));
  return CGAL::Image_3(image);
}

/// The boundary of the complex, facing outward.
TriangleMesh boundary_of(const Complex& complex) {
  TriangleMesh mesh;
  std::map<Triangulation::Vertex_handle, std::uint32_t> numbers;
  for (auto facet = complex.facets_in_complex_begin(); facet != complex.facets_in_complex_end();
       ++facet) {
    const auto cell = facet->first;
    std::array<std::uint32_t, 3> triangle;
    for (int i = 0; i < 3; ++i) {
      const auto vertex = cell->vertex(Triangulation::vertex_triple_index(facet->second, i));
      const auto [entry, is_new] =
          numbers.try_emplace(vertex, static_cast<std::uint32_t>(mesh.vertex_count()));
      if (is_new)
        for (int a = 0; a < 3; ++a) mesh.vertices.push_back(static_cast<float>(vertex->point()[a]));
      triangle[i] = entry->second;
    }
    // The triple faces inward of its cell.
    if (complex.is_in_complex(cell)) std::swap(triangle[1], triangle[2]);
    mesh.triangles.insert(mesh.triangles.end(), triangle.begin(), triangle.end());
  }
  return mesh;
}

void to_lps(const Geometry& geometry, TriangleMesh& mesh) {
  for (std::size_t v = 0; v < mesh.vertices.size(); v += 3) {
    const std::array<double, 3> p = {mesh.vertices[v], mesh.vertices[v + 1], mesh.vertices[v + 2]};
    for (std::size_t row = 0; row < 3; ++row) {
      const double* d = &geometry.direction[3 * row];
      mesh.vertices[v + row] =
          static_cast<float>(geometry.origin[row] + d[0] * p[0] + d[1] * p[1] + d[2] * p[2]);
    }
  }
}

void convert(const Segmentation& whole, const std::string& output, double size, double distance) {
  const Segmentation volume = cropped(whole, kBorder);
  const auto& spacing = volume.geometry.spacing;
  const double voxel = std::cbrt(spacing[0] * spacing[1] * spacing[2]);
  const CGAL::Image_3 image = to_cgal(volume);
  const Domain domain =
      Domain::create_labeled_image_mesh_domain(image, parameters::relative_error_bound = 1e-6);
  const Criteria criteria(parameters::facet_angle = kLeastAngle,
                          parameters::facet_size = size * voxel,
                          parameters::facet_distance = distance * voxel);
  Complex complex;
  initialize_triangulation_from_labeled_image(complex, domain, image, criteria,
                                              static_cast<unsigned char>(0));
  CGAL::refine_mesh_3(complex, domain, criteria, parameters::no_exude(), parameters::no_perturb());
  TriangleMesh mesh = boundary_of(complex);
  to_lps(volume.geometry, mesh);
  write_surface(output, mesh, Space::lps);
}

}  // namespace
}  // namespace vasamesh::baselines

int main(int argc, char** argv) {
  using namespace vasamesh;
  CLI::App app("CGAL's Mesh_3 on a segmentation", "vasamesh_baseline_mesh3");
  double size = 1.6, distance = 0.25;
  app.add_option("--size", size, "largest radius of a facet's surface ball, voxels")
      ->capture_default_str();
  app.add_option("--distance", distance, "largest distance of a facet, voxels")
      ->capture_default_str();
  return baselines::run_program(app, argc, argv,
                                [&](const Segmentation& volume, const std::string& output) {
                                  baselines::convert(volume, output, size, distance);
                                });
}

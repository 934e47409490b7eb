/// \file
/// `vasamesh check`: everything that a solver depends on, for any surface file.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "cli/commands.h"
#include "cli/distinct_files.h"
#include "cli/interrupt.h"
#include "cli/summary.h"
#include "io/marching_cubes.h"
#include "io/report_json.h"
#include "io/surface_io.h"
#include "io/volume_reader.h"
#include "stages/distance.h"
#include "stages/points.h"
#include "stages/principal_curvatures.h"
#include "stages/quality.h"
#include "stages/topology_count.h"
#include "stages/verify.h"
#include "stages/volume_check.h"
#include "types/box.h"
#include "types/mesh_vertex.h"

namespace vasamesh::cli {

namespace {

struct Examination {
  CheckReport check;
  QualityReport quality;
  Distribution curvature;  ///< RMS, 1 / mm
  std::optional<DistanceReport> distance;
  std::size_t reference_triangles = 0;  ///< of the surface that the distance is to
  bool voxel_known = false;
  double step = 0;  ///< mm from the largest coordinate to the next float32
};

/// From the space of the surface file to LPS.
void move_to_lps(TriangleMesh& mesh, Space space, const Geometry& geometry) {
  if (space == Space::lps) return;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    float* v = &mesh.vertices[i];
    if (space == Space::ras) {
      v[0] = -v[0];
      v[1] = -v[1];
      continue;
    }
    const std::array<double, 3> p = {v[0], v[1], v[2]};
    for (std::size_t row = 0; row < 3; ++row) {
      const double* d = &geometry.direction[3 * row];
      v[row] = static_cast<float>(geometry.origin[row] + d[0] * p[0] + d[1] * p[1] + d[2] * p[2]);
    }
  }
}

/// Where no volume tells the voxel: the side of the reference's mean triangle as a square.
double sampling_length(const QualityReport& quality, std::size_t triangles) {
  return std::sqrt(quality.area / static_cast<double>(triangles));
}

float farthest_coordinate(const TriangleMesh& mesh) {
  float farthest = 0;
  for (const float coordinate : mesh.vertices) farthest = std::max(farthest, std::fabs(coordinate));
  return farthest;
}

/// What may be the reason where a surface far out fails, whose file may be finer than float32.
std::string rounding_reason(const Examination& result) {
  constexpr double kCoarse = 0.01;  // of a triangle
  const double side =
      sampling_length(result.quality, static_cast<std::size_t>(result.check.triangles));
  if (!(result.step > kCoarse * side)) return {};
  return fmt::format(
      "; so far out float32 coordinates, to which it is rounded, are {:.2g} mm apart: move it "
      "nearer to the origin",
      result.step);
}

/// What is asked for, else what the file says.
Space space_of(const CheckRequest& request, const PlacedSurface& surface) {
  if (request.space && surface.space && *request.space != *surface.space)
    std::fprintf(stderr,
                 "vasamesh: %s says that it is in %s, and is taken for %s as --space says\n",
                 request.surface.c_str(), space_name(*surface.space), space_name(*request.space));
  return request.space ? *request.space : surface.space.value_or(Space::lps);
}

CheckReport check_against(Backend& backend, const PlacedSurface& surface,
                          const Segmentation& volume, const CheckRequest& request) {
  const BitVolume object = pack_volume(backend, volume.view());
  const Solid solid =
      examine_solid(backend, object.view(), volume.geometry.size, request.connectivity);
  const SolidMatch wanted{&solid, volume.geometry, *surface.space};
  return check_surface(backend, surface.mesh, &wanted);
}

/// The surface that distances are measured to: a file's, in the examined one's space where it names
/// none, or marching cubes of the volume.
std::optional<PlacedSurface> reference_surface(const CheckRequest& request, Space space,
                                               const std::optional<Segmentation>& volume) {
  if (!request.reference.empty()) {
    PlacedSurface reference = read_placed_surface(request.reference);
    reference.space = reference.space.value_or(space);
    return reference;
  }
  if (volume) return PlacedSurface{marching_cubes(*volume), Space::lps};
  return std::nullopt;
}

/// Both surfaces in LPS, where they are not in one space already.
void bring_together(const CheckRequest& request, const std::optional<Segmentation>& volume,
                    PlacedSurface& surface, PlacedSurface& reference) {
  if (*surface.space == *reference.space) return;
  if (!volume && (*surface.space == Space::voxel || *reference.space == Space::voxel))
    throw Error(ErrorCode::usage, request.surface + " is in the space " +
                                      space_name(*surface.space) + ", " + request.reference +
                                      " in " + space_name(*reference.space) +
                                      ": give their volume by --against");
  const Geometry geometry = volume ? volume->geometry : Geometry{};
  for (PlacedSurface* each : {&surface, &reference}) {
    move_to_lps(each->mesh, *each->space, geometry);
    each->space = Space::lps;
  }
}

Box box_round(const TriangleMesh& mesh) {
  Box box;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) box.take_in(vertex_at(mesh, v));
  return box;
}

/// Says so where a distance says nothing: the surfaces are not in one place.
void warn_if_apart(const CheckRequest& request, const TriangleMesh& mesh,
                   const TriangleMesh& reference) {
  if (box_round(mesh).meets(box_round(reference))) return;
  std::fprintf(stderr,
               "vasamesh: %s and %s lie apart: if one is in another space, say so by --space\n",
               request.surface.c_str(),
               (request.reference.empty() ? request.volume : request.reference).c_str());
}

void write_map(Backend& backend, const CheckRequest& request, const PlacedSurface& surface,
               const PrincipalCurvatures& curvatures) {
  TriangleShapes shapes = triangle_shapes(backend, surface.mesh);
  catch_interrupts(true);  // so that no half of a file is left
  write_surface_map(request.map, surface.mesh, *surface.space,
                    {{"rms_curvature", curvatures.rms()},
                     {"kmax", curvatures.most},
                     {"kmin", curvatures.least},
                     {"area", curvatures.area}},
                    {{"edge_ratio", std::move(shapes.edge_ratio)},
                     {"least_angle", std::move(shapes.least_angle)}},
                    &interrupted());
  catch_interrupts(false);
}

/// What can be refused before any work.
void check_request(const CheckRequest& request) {
  if (request.map.empty()) return;
  check_output_path(request.map);
  check_distinct({{"SURFACE", request.surface},
                  {"--against", request.volume},
                  {"the voxels of --against", voxel_file(request.volume)},
                  {"--reference", request.reference}},
                 {{"--map", request.map}});
}

Examination examine(const CheckRequest& request) {
  check_request(request);
  PlacedSurface surface = read_placed_surface(request.surface);
  surface.space = space_of(request, surface);
  TriangleMesh& mesh = surface.mesh;
  std::optional<Segmentation> volume;
  if (!request.volume.empty()) volume = read_segmentation(request.volume, request.read);
  const Context context = make_context({"tbb", "", request.threads, nullptr});
  Backend& backend = *context.backends.back();

  Examination result;
  result.voxel_known = volume.has_value();
  result.step = float_step(farthest_coordinate(mesh));
  result.check = volume ? check_against(backend, surface, *volume, request)
                        : check_surface(backend, mesh, nullptr);
  result.quality = measure_quality(backend, mesh);
  const PrincipalCurvatures curvatures = principal_curvatures(backend, mesh);
  result.curvature = describe_weighted(curvatures.rms(), curvatures.area);
  if (!request.map.empty()) write_map(backend, request, surface, curvatures);
  if (auto reference = reference_surface(request, *surface.space, volume)) {
    bring_together(request, volume, surface, *reference);
    const std::size_t triangles = reference->mesh.triangle_count();
    const double voxel =
        volume ? voxel_length(volume->geometry)
               : sampling_length(measure_quality(backend, reference->mesh), triangles);
    result.distance = measure_distance(backend, mesh, reference->mesh, voxel);
    warn_if_apart(request, mesh, reference->mesh);
    result.reference_triangles = triangles;
  }
  return result;
}

nlohmann::ordered_json to_json(const OneWayDistance& d, double voxel, bool voxel_known) {
  nlohmann::ordered_json json = {{"mean_mm", d.mean}, {"rms_mm", d.rms}, {"maximum_mm", d.maximum}};
  if (voxel_known) {
    json["mean_voxels"] = d.mean / voxel;
    json["rms_voxels"] = d.rms / voxel;
    json["maximum_voxels"] = d.maximum / voxel;
  }
  return json;
}

nlohmann::ordered_json to_json(const CheckRequest& request, const Examination& result) {
  nlohmann::ordered_json json = {{"schema_version", Report::kSchemaVersion},
                                 {"surface", request.surface},
                                 {"check", vasamesh::to_json(result.check)},
                                 {"quality", vasamesh::to_json(result.quality)},
                                 {"rms_curvature", vasamesh::to_json(result.curvature)}};
  if (result.distance) {
    const DistanceReport& d = *result.distance;
    json["distance"] = {{"to", to_json(d.to, d.voxel, result.voxel_known)},
                        {"back", to_json(d.back, d.voxel, result.voxel_known)}};
    json["distance"]["reference_triangles"] = result.reference_triangles;
    if (result.voxel_known) json["distance"]["voxel_mm"] = d.voxel;
  }
  return json;
}

void print(const CheckRequest& request, const Examination& result) {
  if (request.json) {
    fmt::print("{}\n", to_text(to_json(request, result)));
    return;
  }
  print_check(request.surface, result.check, result.quality);
  print_curvature(result.curvature);
  if (result.distance) print_distance(*result.distance, result.voxel_known);
  fmt::print("  {:<28}{}\n", "verdict", result.check.passed ? "passed" : "failed");
}

}  // namespace

void run_check(const CheckRequest& request) {
  catch_interrupts(false);
  const Examination result = examine(request);
  print(request, result);
  if (!result.check.passed)
    throw Error(ErrorCode::failed_check,
                request.surface + ": " + result.check.reason + rounding_reason(result));
}

}  // namespace vasamesh::cli

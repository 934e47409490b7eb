#include "io/report_json.h"

#include "io/surface_io.h"
#include "vasamesh/version.h"

namespace vasamesh {
namespace {

using Json = nlohmann::ordered_json;

template <class Items>
Json list(const Items& items) {
  Json out = Json::array();
  for (const auto& item : items) out.push_back(to_json(item));
  return out;
}

}  // namespace

std::string to_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

Json to_json(const Geometry& geometry) {
  return {{"size", geometry.size},
          {"spacing", geometry.spacing},
          {"origin", geometry.origin},
          {"direction", geometry.direction}};
}

Json to_json(const Parameters& parameters) {
  return {{"neighbours", parameters.neighbours},
          {"normals", parameters.normals == NormalMode::covariance ? "covariance" : "gradient"},
          {"depth", parameters.depth},
          {"kernel_width", parameters.kernel_width},
          {"connectivity", static_cast<int>(parameters.connectivity)},
          {"close_handles", parameters.close_handles},
          {"surface", parameters.surface == SurfaceKind::adaptive ? "adaptive" : "base"},
          {"rho", parameters.edges.rho},
          {"edges_around", parameters.edges.edges_around},
          {"chord_error", parameters.edges.chord_error},
          {"triangles", parameters.edges.triangles},
          {"edge_min", parameters.edges.edge_min},
          {"edge_max", parameters.edges.edge_max},
          {"gradation", parameters.edges.gradation},
          {"stitch", parameters.stitch == StitchMode::exact ? "exact" : "paper"},
          {"min_component", parameters.min_component},
          {"space", space_name(parameters.space)},
          {"max_memory", parameters.max_memory}};
}

Json to_json(const Finding& finding) {
  Json out{{"count", finding.count}};
  out["place"] = finding.count > 0 ? Json(finding.place) : Json(nullptr);
  return out;
}

Json to_json(const Piece& piece) {
  return {{"voxels", piece.voxels},
          {"first_voxel", piece.first_voxel},
          {"cavities", piece.cavities},
          {"handles", piece.handles}};
}

Json to_json(const InputFindings& findings) {
  Json out{{"object_voxels", findings.object_voxels}};
  out["pieces"] = list(findings.pieces);
  out["specks"] = to_json(findings.specks);
  out["cavities"] = to_json(findings.cavities);
  out["handles"] = to_json(findings.handles);
  out["edge_contacts"] = to_json(findings.edge_contacts);
  out["corner_contacts"] = to_json(findings.corner_contacts);
  out["border_contacts"] = to_json(findings.border_contacts);
  out["one_voxel_parts"] = to_json(findings.one_voxel_parts);
  out["anisotropy"] = findings.anisotropy;
  out["blocks"] = findings.blocks;
  out["dropped"] = to_json(findings.dropped);
  return out;
}

Json to_json(const StageReport& stage) {
  return {{"name", stage.name},
          {"backend", stage.backend},
          {"device", stage.device},
          {"seconds", stage.seconds},
          {"device_seconds", stage.device_seconds},
          {"bytes_held", stage.bytes_held},
          {"launches", stage.launches},
          {"copies", stage.copies},
          {"bytes_copied", stage.bytes_copied},
          {"other_arithmetic", stage.other_arithmetic},
          {"host_reason", stage.host_reason},
          {"host_part", stage.host_part},
          {"failure", stage.failure}};
}

Json to_json(const LevelReport& level) {
  return {{"depth", level.depth},           {"cells", level.cells},
          {"nodes", level.nodes},           {"leaves", level.leaves},
          {"iterations", level.iterations}, {"initial_residual", level.initial_residual},
          {"residual", level.residual}};
}

Json to_json(const RelabelReport& relabel) {
  return {{"lattice_nodes", relabel.lattice_nodes},    {"flips", relabel.flips},
          {"stuck_first", relabel.stuck_first},        {"clamped", relabel.clamped},
          {"repair_passes", relabel.repair_passes},    {"handles_closed", relabel.handles_closed},
          {"cavities_closed", relabel.cavities_closed}};
}

Json to_json(const MeshReport& mesh) {
  return {{"predicted_triangles", mesh.predicted_triangles},
          {"attempts", mesh.attempts},
          {"rounds", mesh.rounds},
          {"hard_share", mesh.hard_share},
          {"base_share", mesh.base_share},
          {"front_triangles", mesh.front_triangles},
          {"gaps", mesh.gaps},
          {"gap_triangles", mesh.gap_triangles},
          {"far_points", mesh.far_points}};
}

Json to_json(const Topology& topology) {
  return {
      {"pieces", topology.pieces}, {"handles", topology.handles}, {"cavities", topology.cavities}};
}

Json to_json(const CheckReport& check) {
  Json out{{"passed", check.passed},
           {"reason", check.reason},
           {"vertices", check.vertices},
           {"triangles", check.triangles},
           {"open_edges", check.open_edges},
           {"nonmanifold_edges", check.nonmanifold_edges},
           {"misoriented_edges", check.misoriented_edges},
           {"nonmanifold_vertices", check.nonmanifold_vertices},
           {"isolated_vertices", check.isolated_vertices},
           {"degenerate_triangles", check.degenerate_triangles},
           {"nonfinite_vertices", check.nonfinite_vertices},
           {"intersecting_pairs", check.intersecting_pairs},
           {"inverted_shells", check.inverted_shells}};
  out["topology"] = to_json(check.topology);
  out["shell_genus"] = check.shell_genus;
  out["wanted"] = check.has_wanted ? to_json(check.wanted) : Json(nullptr);
  out["mismatched_pieces"] = check.mismatched_pieces;
  return out;
}

Json to_json(const Distribution& distribution) {
  return {{"mean", distribution.mean},       {"deviation", distribution.deviation},
          {"minimum", distribution.minimum}, {"percentile_5", distribution.percentile_5},
          {"median", distribution.median},   {"percentile_95", distribution.percentile_95},
          {"maximum", distribution.maximum}};
}

Json to_json(const QualityReport& quality) {
  Json out;
  out["edge_ratio"] = to_json(quality.edge_ratio);
  out["edge_ratio_above_08"] = quality.edge_ratio_above_08;
  out["edge_ratio_below_03"] = quality.edge_ratio_below_03;
  out["edge_ratio_below_01"] = quality.edge_ratio_below_01;
  out["edges_within_15"] = quality.edges_within_15;
  out["least_angle"] = to_json(quality.least_angle);
  out["edge_length"] = to_json(quality.edge_length);
  out["size_ratio"] = to_json(quality.size_ratio);
  out["dihedral_angle"] = to_json(quality.dihedral_angle);
  out["sharp_edges"] = quality.sharp_edges;
  out["area"] = quality.area;
  out["volume"] = quality.volume;
  return out;
}

Json to_json(const Report& report) {
  Json out{{"schema_version", Report::kSchemaVersion}, {"version", version()}};
  out["geometry"] = to_json(report.geometry);
  out["parameters"] = to_json(report.parameters);
  out["input"] = to_json(report.input);
  out["points"] = report.points;
  out["thin_points"] = report.thin_points;
  out["bytes_planned"] = report.bytes_planned;
  out["distance_limit"] = report.distance_limit;
  out["stages"] = list(report.stages);
  out["levels"] = list(report.levels);
  out["relabel"] = to_json(report.relabel);
  out["mesh"] = to_json(report.mesh);
  out["check"] = to_json(report.check);
  out["quality"] = to_json(report.quality);
  return out;
}

}  // namespace vasamesh

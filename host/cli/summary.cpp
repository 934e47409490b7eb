#include "cli/summary.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/surface_io.h"
#include "stages/points.h"

namespace vasamesh::cli {

namespace {

std::string plural(std::int64_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string describe(const Topology& topology) {
  return plural(topology.pieces, "piece", "pieces") + ", " +
         plural(topology.handles, "handle", "handles") + ", " +
         plural(topology.cavities, "cavity", "cavities");
}

/// What smooths the steps of labels that were enlarged, and is not asked for; empty where there are
/// none.
std::string describe_blocks(const Report& report) {
  const std::array<std::int64_t, 3>& blocks = report.input.blocks;
  const Scale scale = make_scale(report.geometry);
  double longest = 0;  // side of a block, in voxels
  for (std::size_t a = 0; a < 3; ++a)
    if (blocks[a] > 1) longest = std::max(longest, static_cast<double>(blocks[a]) * scale[a]);
  const double width = std::min(Parameters{}.kernel_width * longest, Parameters::kWidestKernel);
  if (width <= report.parameters.kernel_width) return {};
  return fmt::format(
      "labels constant over blocks of {} voxels: --kernel-width {:.1f} smooths their steps",
      fmt::join(blocks, " x "), width);
}

/// What a user may want to look at in the segmentation, each with its first voxel.
void print_findings(const Report& report) {
  const InputFindings& findings = report.input;
  const std::vector<std::pair<const char*, const Finding*>> entries = {
      {"pieces dropped as too small", &findings.dropped},
      {"pieces of fewer than 8 voxels", &findings.specks},
      {"handles", &findings.handles},
      {"cavities", &findings.cavities},
      {"contacts over an edge", &findings.edge_contacts},
      {"contacts over a corner", &findings.corner_contacts},
      {"voxels on the border", &findings.border_contacts},
      {"voxels in one-voxel parts", &findings.one_voxel_parts}};
  const char* title = "Found";
  for (const auto& [name, finding] : entries) {
    if (finding->count == 0) continue;
    fmt::print("{:<10}{}: {}, the first at voxel {}\n", std::exchange(title, ""), name,
               finding->count, fmt::join(finding->place, " "));
  }
  if (const std::string blocks = describe_blocks(report); !blocks.empty())
    fmt::print("{:<10}{}\n", title, blocks);
}

/// What was closed on demand, so that the surface is without it.
std::string describe_closed(const RelabelReport& relabel) {
  std::string closed;
  if (relabel.handles_closed > 0) closed = plural(relabel.handles_closed, "handle", "handles");
  if (relabel.cavities_closed > 0)
    closed +=
        (closed.empty() ? "" : " and ") + plural(relabel.cavities_closed, "cavity", "cavities");
  return closed.empty() ? closed : " but for " + closed + " closed";
}

/// How the triangles of an adaptive surface came about.
void print_mesh(const MeshReport& mesh) {
  fmt::print("{:<10}", "Mesh");
  if (mesh.base_share == 1) {
    fmt::print("the base surface's, since {}",
               mesh.attempts > 1 ? "no adaptive one was proven"
                                 : "its handles are as small as triangles would be");
  } else if (mesh.front_triangles == 0) {
    fmt::print("the base surface remeshed");
  } else {
    fmt::print("{} triangles by the front, {} in {}; {:.1f} % of the area remeshed",
               mesh.front_triangles, mesh.gap_triangles, plural(mesh.gaps, "gap", "gaps"),
               100 * mesh.hard_share);
  }
  if (mesh.base_share > 0 && mesh.base_share < 1)
    fmt::print("; {:.2f} % of the area is the base surface's", 100 * mesh.base_share);
  fmt::print("; {}\n", plural(mesh.attempts, "attempt", "attempts"));
}

/// Where edges are too long for what the segmentation has there.
void print_far_points(const Report& report) {
  if (report.mesh.far_points == 0) return;
  fmt::print(
      "{:<10}in places about {:.3g} mm or more from marching cubes, the limit: ask for "
      "shorter edges\n",
      "Distance", report.distance_limit);
}

/// The devices that stages ran on, and those that failed, so that the CPU finished.
void print_devices(const std::vector<StageReport>& stages) {
  std::map<std::string, std::pair<int, std::string>> used;  // stages, other arithmetic
  const bool has_failed = std::any_of(stages.begin(), stages.end(), [](const StageReport& stage) {
    return !stage.failure.empty();
  });
  for (const StageReport& stage : stages) {
    if (stage.launches == 0 || !stage.failure.empty()) continue;
    auto& [count, arithmetic] = used[stage.device];
    ++count;
    if (!has_failed) arithmetic = stage.other_arithmetic;
  }
  for (const auto& [device, use] : used) {
    const auto& [count, arithmetic] = use;
    fmt::print("{:<10}{}: {} of {} stages{}\n", "Device", device, count, stages.size(),
               arithmetic.empty() ? "" : "; it " + arithmetic + ": its bytes may not be the CPU's");
  }
  for (const StageReport& stage : stages)
    if (!stage.failure.empty())
      fmt::print("{:<10}{} failed in {}: {}; done again on the CPU\n", "Device", stage.device,
                 stage.name, stage.failure);
}

void print_times(const std::vector<StageReport>& stages) {
  double total = 0;
  std::string parts;
  for (const StageReport& stage : stages) {
    total += stage.seconds;
    parts += fmt::format("{}{} {:.2f}", parts.empty() ? "" : ", ", stage.name, stage.seconds);
  }
  fmt::print("{:<10}{:.2f} s: {}\n", "Time", total, parts);
}

void print_row(const char* name, std::int64_t count) { fmt::print("  {:<28}{}\n", name, count); }

void print_distribution(const char* name, const Distribution& d) {
  fmt::print(
      "  {:<28}mean {:.3f}, sd {:.3f}, min {:.3f}, 5 % {:.3f}, median {:.3f}, 95 % {:.3f}, "
      "max {:.3f}\n",
      name, d.mean, d.deviation, d.minimum, d.percentile_5, d.median, d.percentile_95, d.maximum);
}

void print_one_way(const char* name, const OneWayDistance& d, double voxel, bool voxel_known) {
  fmt::print("  {:<28}mean {:.4f}, rms {:.4f}, largest {:.4f} mm", name, d.mean, d.rms, d.maximum);
  if (voxel_known)
    fmt::print("; {:.3f}, {:.3f}, {:.3f} voxels", d.mean / voxel, d.rms / voxel, d.maximum / voxel);
  fmt::print("\n");
}

}  // namespace

void print_conversion(const std::string& input, const std::string& output, const Report& report) {
  const Geometry& geometry = report.geometry;
  fmt::print("{:<10}{}: {} voxels of {:.4g} mm, {} in the object\n", "Input", input,
             fmt::join(geometry.size, " x "), fmt::join(geometry.spacing, " x "),
             report.input.object_voxels);
  print_findings(report);
  fmt::print("{:<10}{}: {} triangles, {} vertices, {}, mm\n", "Surface", output,
             report.check.triangles, report.check.vertices,
             upper_space_name(report.parameters.space));
  fmt::print("{:<10}{}, as the segmentation{}; closed, manifold, outward, no self-intersection\n",
             "Proof", describe(report.check.topology), describe_closed(report.relabel));
  if (report.parameters.surface == SurfaceKind::adaptive) print_mesh(report.mesh);
  const QualityReport& quality = report.quality;
  fmt::print(
      "{:<10}edge ratio {:.2f}, least angle {:.0f} degrees on average; edges of {:.3g} to {:.3g} "
      "mm\n",
      "Quality", quality.edge_ratio.mean, quality.least_angle.mean, quality.edge_length.minimum,
      quality.edge_length.maximum);
  print_far_points(report);
  print_devices(report.stages);
  print_times(report.stages);
}

void print_check(const std::string& surface, const CheckReport& check,
                 const QualityReport& quality) {
  fmt::print("{}\n", surface);
  print_row("vertices", check.vertices);
  print_row("triangles", check.triangles);
  print_row("open edges", check.open_edges);
  print_row("non-manifold edges", check.nonmanifold_edges);
  print_row("misoriented edges", check.misoriented_edges);
  print_row("non-manifold vertices", check.nonmanifold_vertices);
  print_row("isolated vertices", check.isolated_vertices);
  print_row("degenerate triangles", check.degenerate_triangles);
  print_row("non-finite vertices", check.nonfinite_vertices);
  print_row("intersecting pairs", check.intersecting_pairs);
  print_row("inverted shells", check.inverted_shells);
  fmt::print("  {:<28}{}\n", "topology", describe(check.topology));
  if (check.has_wanted) {
    fmt::print("  {:<28}{}\n", "the segmentation's", describe(check.wanted));
    print_row("pieces that do not match", check.mismatched_pieces);
  }
  print_distribution("edge ratio", quality.edge_ratio);
  fmt::print("  {:<28}{:.1f} % at 0.8 and above, {:.1f} % below 0.3, {:.2f} % below 0.1\n", "",
             100 * quality.edge_ratio_above_08, 100 * quality.edge_ratio_below_03,
             100 * quality.edge_ratio_below_01);
  print_distribution("least angle, degrees", quality.least_angle);
  print_distribution("edge length, mm", quality.edge_length);
  print_distribution("size ratio of neighbours", quality.size_ratio);
  print_distribution("dihedral angle, degrees", quality.dihedral_angle);
  print_row("edges below 60 degrees", quality.sharp_edges);
  fmt::print("  {:<28}{:.6g} mm^2\n", "area", quality.area);
  fmt::print("  {:<28}{:.6g} mm^3\n", "volume", quality.volume);
}

void print_curvature(const Distribution& rms) { print_distribution("RMS curvature, 1/mm", rms); }

void print_distance(const DistanceReport& distance, bool voxel_known) {
  print_one_way("distance to the reference", distance.to, distance.voxel, voxel_known);
  print_one_way("and back", distance.back, distance.voxel, voxel_known);
}

}  // namespace vasamesh::cli

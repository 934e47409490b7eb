#include "vasamesh/parameters.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

[[noreturn]] void out_of_range(const char* option, const std::string& range) {
  throw Error(ErrorCode::usage, std::string(option) + " is out of its range: give " + range);
}

/// The value in as few digits as tell it.
std::string number(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// And whether nobody chose it.
std::string number(double value, double standard) {
  return number(value) + (value == standard ? " (the default)" : "");
}

bool within(double value, double least, double most) {
  return std::isfinite(value) && value >= least && value <= most;
}

void check_voxels(const char* option, double length, double least, double most) {
  if (!within(length, least, most))
    out_of_range(option, number(least) + " to " + number(most) + " voxels");
}

void validate(const EdgeLengths& e) {
  constexpr double kLeast = 1e-3;
  constexpr std::int64_t kMostTriangles = 1'000'000'000;
  if (!within(e.rho, kLeast, 2)) out_of_range("--rho", "0.001 to 2");
  if (e.edges_around != 0 && !within(e.edges_around, 4, 100))
    out_of_range("--edges-around", "4 to 100 (0: by rho)");
  if (e.chord_error != 0 && !within(e.chord_error, kLeast, 1))
    out_of_range("--chord-error", "0.001 to 1 voxel (0: by rho)");
  if (e.triangles < 0 || e.triangles > kMostTriangles)
    out_of_range("--triangles", "how many are wanted, up to 1,000,000,000 (0: by rho)");
  check_voxels("--edge-min", e.edge_min, e.kLeastEdge, e.kLongestEdge);
  check_voxels("--edge-max", e.edge_max, e.kLeastEdge, e.kLongestEdge);
  if (e.edge_min > e.edge_max)
    throw Error(ErrorCode::usage, "--edge-min " + number(e.edge_min, EdgeLengths{}.edge_min) +
                                      " is above --edge-max " +
                                      number(e.edge_max, EdgeLengths{}.edge_max) +
                                      ": lower the one or raise the other");
  if (!within(e.gradation, 0.01, 2)) out_of_range("--gradation", "0.01 to 2");
  if ((e.edges_around != 0) + (e.chord_error != 0) + (e.triangles != 0) > 1)
    throw Error(
        ErrorCode::usage,
        "--edges-around, --chord-error and --triangles exclude each other: give one of them");
}

}  // namespace

void set_preset(const std::string& name, Parameters& p) {
  p.edges = {};
  p.stitch = StitchMode::exact;
  if (name == "default") return;
  if (name == "paper") {
    p.edges.edge_min = p.edges.edge_max = 1.05;
    p.stitch = StitchMode::paper;
  } else if (name == "simulator") {
    p.edges.rho = 0.8;
    p.edges.edge_max = 3;
    p.edges.gradation = 0.3;
  } else {
    throw Error(ErrorCode::usage,
                "there is no preset '" + name + "': give default, paper or simulator");
  }
}

void validate(const Parameters& p) {
  validate(p.edges);
  if (p.neighbours < 3 || p.neighbours > 64) out_of_range("--neighbours", "3 to 64");
  if (p.depth < 0 || p.depth > 24) out_of_range("--depth", "0 (automatic) to 24");
  check_voxels("--kernel-width", p.kernel_width, p.kLeastKernel, p.kWidestKernel);
  if (p.min_component < 0) out_of_range("--min-component", "0 (keep all) or more voxels");
  if (p.max_memory < 0) out_of_range("--max-memory", "0 (no limit) or more bytes");
  if (p.normals != NormalMode::covariance && p.normals != NormalMode::gradient)
    out_of_range("--normals", "covariance or gradient");
  if (p.surface != SurfaceKind::adaptive && p.surface != SurfaceKind::base)
    out_of_range("--surface", "adaptive or base");
  if (p.stitch != StitchMode::exact && p.stitch != StitchMode::paper)
    out_of_range("--stitch", "exact or paper");
  if (p.space != Space::lps && p.space != Space::ras && p.space != Space::voxel)
    out_of_range("--space", "lps, ras or voxel");
  const int c = static_cast<int>(p.connectivity);
  if (c != 6 && c != 18 && c != 26) out_of_range("--connectivity", "6, 18 or 26");
}

}  // namespace vasamesh

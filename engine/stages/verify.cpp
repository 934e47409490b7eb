#include "stages/verify.h"

#include <cmath>

#include "backend/in_steps.h"
#include "backend/ranges.h"
#include "stages/intersect.h"
#include "stages/manifold.h"
#include "stages/pieces.h"
#include "stages/predicates.h"
#include "stages/shells.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 32768;  // triangles a task takes

void require_indices(const Backend& backend, const TriangleMesh& mesh) {
  if (mesh.vertices.size() % 3 != 0 || mesh.triangles.size() % 3 != 0)
    throw Error(ErrorCode::bad_input,
                "the surface is cut short: its numbers are not in threes; write it anew");
  const std::size_t count = mesh.vertex_count();
  in_steps(backend, mesh.triangles.size(), [&](std::size_t i) {
    if (mesh.triangles[i] >= count)
      throw Error(ErrorCode::bad_input, "triangle " + std::to_string(i / 3) + " names vertex " +
                                            std::to_string(mesh.triangles[i]) + " of " +
                                            std::to_string(count) + "; write the surface anew");
  });
}

/// What a triangle can take part in.
enum TriangleState : std::uint8_t {
  kRepeated = 0,  // a vertex twice: in nothing
  kUnusable = 1,  // not finite, or on a line: in the adjacency alone
  kWhole = 2,
};

bool finite(const TriangleMesh& mesh, std::size_t v) {
  const float* p = mesh.vertices.data() + 3 * v;
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

TriangleState state_of(const TriangleMesh& mesh, std::size_t t, bool& degenerate) {
  const std::uint32_t* v = mesh.triangles.data() + 3 * t;
  degenerate = v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
  if (degenerate) return kRepeated;
  if (!finite(mesh, v[0]) || !finite(mesh, v[1]) || !finite(mesh, v[2])) return kUnusable;
  const auto at = [&](int i) { return mesh.vertices.data() + 3 * std::size_t{v[i]}; };
  degenerate = collinear(at(0), at(1), at(2));
  return degenerate ? kUnusable : kWhole;
}

/// States of all triangles; counts the degenerate ones.
std::vector<std::uint8_t> triangle_states(Backend& backend, const TriangleMesh& mesh,
                                          CheckReport& report) {
  auto states = filled_in_steps<std::uint8_t>(backend, mesh.triangle_count());
  const auto find = [&](std::size_t begin, std::size_t end) {
    std::int64_t count = 0;
    for (std::size_t t = begin; t < end; ++t) {
      bool is_degenerate = false;
      states[t] = state_of(mesh, t, is_degenerate);
      count += is_degenerate;
    }
    return count;
  };
  report.degenerate_triangles =
      reduce_ranges(backend, states.size(), kGrain, std::int64_t{0}, find);
  return states;
}

std::vector<std::uint8_t> at_least(const Backend& backend, const std::vector<std::uint8_t>& states,
                                   TriangleState state) {
  auto chosen = filled_in_steps<std::uint8_t>(backend, states.size());
  in_steps(backend, states.size(), [&](std::size_t t) { chosen[t] = states[t] >= state; });
  return chosen;
}

void take(const ManifoldCounts& counts, CheckReport& report) {
  report.open_edges = counts.open_edges;
  report.nonmanifold_edges = counts.nonmanifold_edges;
  report.misoriented_edges = counts.misoriented_edges;
  report.nonmanifold_vertices = counts.nonmanifold_vertices;
  report.isolated_vertices = counts.isolated_vertices;
}

void take(const Shells& shells, CheckReport& report) {
  for (const Shell& shell : shells.shells) {
    report.shell_genus.push_back(shell.genus());
    report.topology.handles += shell.genus();
    (shell.outward() ? report.topology.pieces : report.topology.cavities)++;
    report.inverted_shells += shell.inverted();
  }
}

std::string text(const Topology& t) {
  return std::to_string(t.pieces) + "/" + std::to_string(t.handles) + "/" +
         std::to_string(t.cavities);
}

std::string reason_of(const CheckReport& r) {
  std::string reason;
  const auto add = [&](std::int64_t count, const char* one, const char* many) {
    if (count == 0) return;
    reason +=
        (reason.empty() ? "" : ", ") + std::to_string(count) + " " + (count == 1 ? one : many);
  };
  if (r.triangles == 0) reason = "no triangles";
  add(r.nonfinite_vertices, "vertex that is not finite", "vertices that are not finite");
  add(r.open_edges, "open edge", "open edges");
  add(r.nonmanifold_edges, "edge of more than two triangles", "edges of more than two triangles");
  add(r.misoriented_edges, "edge between triangles of opposite orientation",
      "edges between triangles of opposite orientation");
  add(r.nonmanifold_vertices, "vertex of more than one fan", "vertices of more than one fan");
  add(r.isolated_vertices, "vertex of no triangle", "vertices of no triangle");
  add(r.degenerate_triangles, "degenerate triangle", "degenerate triangles");
  if (r.intersecting_pairs == 0)  // else a shell may be half inside another
    add(r.inverted_shells, "shell facing the wrong way", "shells facing the wrong way");
  add(r.intersecting_pairs, "intersecting pair of triangles", "intersecting pairs of triangles");
  add(r.mismatched_pieces, "piece of another topology than the segmentation's",
      "pieces of another topology than the segmentation's");
  if (r.has_wanted && r.topology != r.wanted)
    reason += (reason.empty() ? "" : ", ") + ("pieces/handles/cavities " + text(r.topology)) +
              " instead of " + text(r.wanted);
  return reason;
}

}  // namespace

CheckReport check_surface(Backend& backend, const TriangleMesh& mesh, const SolidMatch* wanted) {
  require_indices(backend, mesh);
  CheckReport report;
  report.vertices = static_cast<std::int64_t>(mesh.vertex_count());
  report.triangles = static_cast<std::int64_t>(mesh.triangle_count());
  in_steps(backend, mesh.vertex_count(),
           [&](std::size_t v) { report.nonfinite_vertices += !finite(mesh, v); });

  const std::vector<std::uint8_t> states = triangle_states(backend, mesh, report);
  Shells shells;
  TriangleTree tree;
  backend.run(2, [&](std::size_t half) {  // each half has work of one thread alone
    if (half == 0) {
      const ManifoldCounts manifold = count_manifold(backend, mesh, vertex_corners(backend, mesh));
      take(manifold, report);
      shells = find_shells(backend, mesh, at_least(backend, states, kUnusable), manifold);
    } else {
      tree = build_triangle_tree(backend, mesh, at_least(backend, states, kWhole));
    }
  });
  report.intersecting_pairs = find_intersections(backend, mesh, tree).count;
  find_nesting(backend, mesh, tree, shells);
  take(shells, report);
  if (wanted) {
    report.has_wanted = true;
    report.wanted = wanted->solid->topology;
    report.mismatched_pieces = count_mismatches(backend, mesh, tree, shells, *wanted);
  }
  report.reason = reason_of(report);
  report.passed = report.reason.empty();
  return report;
}

}  // namespace vasamesh

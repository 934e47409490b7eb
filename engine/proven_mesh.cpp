#include "proven_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "stages/polygonize.h"
#include "stages/surface.h"
#include "stages/volume_check.h"
#include "vasamesh/errors.h"

namespace vasamesh {

namespace {

/// Takes a surface from padded voxel units to where it is asked for, and proves it there.
CheckReport prove(Scheduler& scheduler, const SolidMatch& wanted, TriangleMesh& mesh) {
  scheduler.begin("check", Stage::verify, "edges, fans, shells, pairs that need exact predicates");
  Backend& backend = scheduler.backend_for(Stage::verify);
  place_in_space(backend, wanted.geometry, wanted.space, mesh);
  return check_surface(backend, mesh, &wanted);
}

/// The best of the polygonizer's surfaces that pass their proof, with its check and its making in
/// the report; none when none does.
std::optional<TriangleMesh> proven_surface(Polygonizer& polygonizer, Scheduler& scheduler,
                                           const SolidMatch& wanted, Report& report) {
  std::optional<TriangleMesh> best;
  while (std::optional<TriangleMesh> mesh = polygonizer.next()) {
    const CheckReport check = prove(scheduler, wanted, *mesh);
    const Verdict verdict = polygonizer.judge(check);
    if (verdict == Verdict::refuse) continue;
    best = std::move(mesh);
    report.check = check;
    report.mesh = polygonizer.report();
    if (verdict == Verdict::take) break;
  }
  if (best) polygonizer.check_count(report.check.triangles);
  report.mesh.attempts = polygonizer.report().attempts;
  return best;
}

/// The base surface, with its check in the report.
TriangleMesh proven_base(const Lattice& lattice, Scheduler& scheduler, const SolidMatch& wanted,
                         Report& report) {
  scheduler.begin("surface", Stage::surface);
  TriangleMesh mesh = extract_base_surface(scheduler.backend_for(Stage::surface), lattice);
  report.check = prove(scheduler, wanted, mesh);
  report.mesh.base_share = 1;
  ++report.mesh.attempts;
  if (!report.check.passed)
    throw Error(ErrorCode::failed_check,
                "the surface failed its proof and is not written: " + report.check.reason +
                    far_out(wanted.geometry, wanted.space));
  return mesh;
}

/// The adaptive surface, with its check and its making in the report; none where it is not
/// worthwhile, or not proven. \throws CountRefused
std::optional<TriangleMesh> adaptive_mesh(const Labelled& labelled, const Parameters& parameters,
                                          const SolidMatch& wanted, Scheduler& scheduler,
                                          Report& report) {
  scheduler.begin("surface", Stage::surface);
  Polygonizer polygonizer(
      scheduler, labelled.lattice, labelled.size, labelled.scale,
      extract_base_surface(scheduler.backend_for(Stage::surface), labelled.lattice), parameters);
  report.mesh = polygonizer.report();
  if (!polygonizer.is_worthwhile(labelled.solid.topology)) return std::nullopt;
  return proven_surface(polygonizer, scheduler, wanted, report);
}

/// The number of triangles to ask for next; none where the one that is asked for is met.
std::optional<double> possible_instead(const Labelled& labelled, const Parameters& parameters,
                                       const SolidMatch& wanted, Scheduler& scheduler) {
  try {
    Report report;
    if (adaptive_mesh(labelled, parameters, wanted, scheduler, report)) return std::nullopt;
    return static_cast<double>(parameters.edges.triangles);
  } catch (const CountRefused& refusal) {
    return refusal.possible();
  }
}

/// Refuses a number of triangles with one that is met: what one refusal names is asked for, and
/// what the next names, a few times, where such surfaces are quickly made.
[[noreturn]] void refuse_with_number_that_is_met(const CountRefused& first,
                                                 const Labelled& labelled, Parameters parameters,
                                                 const SolidMatch& match, Scheduler& scheduler) {
  constexpr int kTries = 6;
  constexpr double kMostTriangles = 20'000, kStep = 1.1;
  const auto wanted = static_cast<double>(parameters.edges.triangles);
  const bool more = first.possible() > wanted;
  double possible = first.possible();
  for (int i = 0; i < kTries && possible >= 1 && possible <= kMostTriangles; ++i) {
    parameters.edges.triangles = std::llround(possible);
    const std::optional<double> next = possible_instead(labelled, parameters, match, scheduler);
    if (!next) throw CountRefused(wanted, possible, true);
    possible = more ? std::max(*next, kStep * possible) : std::min(*next, possible / kStep);
  }
  throw CountRefused(wanted, possible, false);
}

}  // namespace

TriangleMesh proven_mesh(const Labelled& labelled, const Parameters& parameters,
                         const SolidMatch& wanted, Scheduler& scheduler, Report& report) {
  if (parameters.surface == SurfaceKind::base)
    return proven_base(labelled.lattice, scheduler, wanted, report);
  try {
    if (std::optional<TriangleMesh> mesh =
            adaptive_mesh(labelled, parameters, wanted, scheduler, report))
      return std::move(*mesh);
  } catch (const CountRefused& refusal) {
    refuse_with_number_that_is_met(refusal, labelled, parameters, wanted, scheduler);
  }
  return proven_base(labelled.lattice, scheduler, wanted, report);
}

}  // namespace vasamesh

#include "vasamesh/pipeline.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "byte_plan.h"
#include "scheduler.h"
#include "stages/lattice.h"
#include "stages/normals.h"
#include "stages/octree.h"
#include "stages/points.h"
#include "stages/poisson.h"
#include "stages/polygonize.h"
#include "stages/quality.h"
#include "stages/relabel.h"
#include "stages/surface.h"
#include "stages/topology_count.h"
#include "stages/verify.h"
#include "stages/volume_check.h"

namespace vasamesh {

namespace {

/// The piece whose voxels are nearest to a node of the cell lattice; kNone past two voxels.
std::int32_t piece_near(const PieceLookup& lookup, const std::array<int, 3>& node) {
  for (int reach = 0; reach <= 2; ++reach)
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const std::int32_t piece =
              lookup.at((node[0] >> 1) + x, (node[1] >> 1) + y, (node[2] >> 1) + z);
          if (piece != PieceLookup::kNone) return piece;
        }
  return PieceLookup::kNone;
}

/// Takes the filled tunnels and cavities off what the surface must have.
void take_off(const std::vector<Closing>& closings, Solid& solid, RelabelReport& report) {
  for (const Closing& closing : closings) {
    const std::int32_t piece = piece_near(solid.lookup, closing.node);
    if (piece == PieceLookup::kNone) continue;
    Piece& own = solid.findings.pieces[static_cast<std::size_t>(piece)];
    --(closing.tunnel ? own.handles : own.cavities);
    --(closing.tunnel ? solid.topology.handles : solid.topology.cavities);
    ++(closing.tunnel ? report.handles_closed : report.cavities_closed);
  }
}

/// Takes a surface from padded voxel units to where it is asked for, and proves it there.
CheckReport prove(Scheduler& scheduler, const SolidMatch& wanted, TriangleMesh& mesh) {
  scheduler.begin("check", Stage::verify);
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

/// The segmentation as a solid, packed into bits that stay with the caller.
Solid examined(const VolumeView& volume, const Parameters& parameters, Scheduler& scheduler,
               BitVolume& object) {
  scheduler.begin("input", Stage::points);
  Backend& host = scheduler.host();
  Backend& points_on = scheduler.backend_for(Stage::points);
  object = pack_volume(points_on, volume);
  points_on.on_host(object.words.view());
  Solid solid = examine_solid(host, object.view(), volume.geometry.size, parameters.connectivity);
  if (parameters.min_component > 1)
    drop_small_components(host, object, volume.geometry.size, parameters.connectivity,
                          parameters.min_component, solid);
  if (solid.findings.object_voxels == 0 && solid.findings.dropped.count > 0)
    throw Error(ErrorCode::bad_input, "all pieces have fewer voxels than --min-component, " +
                                          std::to_string(parameters.min_component) +
                                          ": ask for less");
  if (solid.findings.object_voxels == 0)
    throw Error(ErrorCode::bad_input,
                "nothing is in the foreground: give a segmentation with object voxels");
  const auto [least, most] =
      std::minmax_element(volume.geometry.spacing.begin(), volume.geometry.spacing.end());
  solid.findings.anisotropy = *most / *least;
  return solid;
}

/// The samples of the segmentation's boundary, with their normals, and the octree's bricks.
struct Samples {
  PointCloud points;
  OctreeBricks bricks;
};

Samples oriented_samples(const BitVolume& object, const Scale& scale, const Parameters& parameters,
                         Scheduler& scheduler, Report& report) {
  scheduler.begin("points", Stage::points);
  Backend& points_on = scheduler.backend_for(Stage::points);
  PointCloud points = extract_points(points_on, object, scale);
  OctreeBricks bricks = octree_bricks(points_on, points, parameters);
  report.points = static_cast<std::int64_t>(points.count);
  report.thin_points = static_cast<std::int64_t>(points.thin_count);

  const BytePlan plan = plan_bytes(object.view(), points, bricks.count());
  scheduler.check_memory(plan);
  report.bytes_planned = static_cast<std::int64_t>(plan.most);

  scheduler.begin("normals", Stage::normals);
  estimate_normals(scheduler.backend_for(Stage::normals), object, scale, parameters, points);
  return {std::move(points), std::move(bricks)};
}

/// The cell lattice with the solid's labels and the indicator function's values. Points and octree
/// are gone once it is there.
Lattice sampled_lattice(const BitVolume& object, const Scale& scale, const Parameters& parameters,
                        Scheduler& scheduler, Report& report) {
  const Samples samples = oriented_samples(object, scale, parameters, scheduler, report);
  const PointCloud& points = samples.points;

  scheduler.begin("octree", Stage::octree);
  Backend& octree_on = scheduler.backend_for(Stage::octree);
  Octree octree = build_octree(octree_on, samples.bricks, scale);
  assemble_poisson(octree_on, points, scale, parameters, octree);

  scheduler.begin("poisson", Stage::poisson);
  solve_poisson(scheduler, parameters, octree, report.levels);
  subtract_isovalue(scheduler.backend_for(Stage::poisson), points, scale, octree);

  scheduler.begin("topology", Stage::lattice);
  return build_lattice(scheduler.backend_for(Stage::lattice), object, points, scale, octree,
                       parameters);
}

/// The segmentation carried over to the cell lattice: what the surface must be, and where it runs.
struct Labelled {
  std::array<int, 3> size;  ///< padded voxels along each axis
  Scale scale;
  Solid solid;
  Lattice lattice;
};

Labelled label(const VolumeView& volume, const Parameters& parameters, Scheduler& scheduler,
               Report& report) {
  BitVolume object;
  Solid solid = examined(volume, parameters, scheduler, object);
  const Scale scale = make_scale(volume.geometry);
  Lattice lattice = sampled_lattice(object, scale, parameters, scheduler, report);
  std::vector<Closing> closings;
  report.relabel =
      relabel(scheduler, scale, lattice, parameters.close_handles ? &closings : nullptr);
  report.input = solid.findings;
  report.distance_limit = distance_limit(scale) / scale[0] * volume.geometry.spacing[0];
  take_off(closings, solid, report.relabel);
  return {object.size, scale, std::move(solid), std::move(lattice)};
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

/// The surface that is asked for, with its check and its making in the report.
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

/// The whole method, in the order of the paper. What the next step does not need is gone before it.
Result run_pipeline(const VolumeView& volume, const Parameters& parameters, Scheduler& scheduler) {
  Result result;
  Report& report = result.report;
  report.geometry = volume.geometry;
  report.parameters = parameters;
  const Labelled labelled = label(volume, parameters, scheduler, report);
  const SolidMatch wanted = {&labelled.solid, volume.geometry, parameters.space};
  result.mesh = proven_mesh(labelled, parameters, wanted, scheduler, report);
  scheduler.begin("quality", Stage::mesh, "sums in double, which not all devices have");
  report.quality = measure_quality(scheduler.host(), result.mesh);
  scheduler.end();
  report.stages = scheduler.take_reports();
  return result;
}

}  // namespace

struct Converter::State {
  explicit State(Context given) : context(std::move(given)) { keep_memory(true); }
  ~State() { keep_memory(false); }

  void keep_memory(bool keep) {
    for (const auto& backend : context.backends)
      if (backend) backend->keep_memory(keep);
  }

  Context context;
};

Converter::Converter(Context context) : state_(std::make_unique<State>(std::move(context))) {}
Converter::~Converter() = default;
Converter::Converter(Converter&&) noexcept = default;
Converter& Converter::operator=(Converter&&) noexcept = default;

Result Converter::convert(const VolumeView& volume, const Parameters& parameters) {
  return vasamesh::convert(volume, parameters, state_->context);
}

Result convert(const VolumeView& volume, const Parameters& parameters, Context& context) {
  validate(parameters);
  check_volume(volume, parameters.space);
  Scheduler scheduler(context, static_cast<std::size_t>(parameters.max_memory));
  try {
    try {
      return run_pipeline(volume, parameters, scheduler);
    } catch (const DeviceFailure& failure) {
      scheduler.fall_back(failure);
    }
    return run_pipeline(volume, parameters, scheduler);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::refused, "out of memory: convert a part of the volume");
  }
}

}  // namespace vasamesh

#include "vasamesh/pipeline.h"

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "byte_plan.h"
#include "proven_mesh.h"
#include "scheduler.h"
#include "stages/close_handles.h"
#include "stages/lattice.h"
#include "stages/normals.h"
#include "stages/octree.h"
#include "stages/points.h"
#include "stages/poisson.h"
#include "stages/quality.h"
#include "stages/relabel.h"
#include "stages/topology_count.h"
#include "stages/volume_check.h"

namespace vasamesh {

namespace {

/// The segmentation as a solid, packed into bits that stay with the caller.
Solid examined(const VolumeView& volume, const Parameters& parameters, Scheduler& scheduler,
               BitVolume& object) {
  scheduler.begin("input", Stage::points, "pieces, handles and cavities");
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

  scheduler.begin("octree", Stage::octree, "tables of bricks");
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

/// The segmentation on the cell lattice, with what was done to it in the report.
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
  report.distance_limit = lattice.limit / scale[0] * volume.geometry.spacing[0];
  take_off(closings, solid, report.relabel);
  return {object.size, scale, std::move(solid), std::move(lattice)};
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
